#include "server/wire/convert_shared.h"

#include <cstdint>
#include <string>
#include <vector>

namespace procgen {
namespace {

v1::ElementType ElementTypeOf(SharedArray::Element element) {
  switch (element) {
    case SharedArray::Element::kUint8:
      return v1::ELEMENT_TYPE_UINT8;
    case SharedArray::Element::kBool:
      return v1::ELEMENT_TYPE_BOOL;
    case SharedArray::Element::kInt32:
      return v1::ELEMENT_TYPE_INT32;
    case SharedArray::Element::kInt64:
      return v1::ELEMENT_TYPE_INT64;
    case SharedArray::Element::kFloat32:
      return v1::ELEMENT_TYPE_FLOAT32;
  }
  return v1::ELEMENT_TYPE_UNSPECIFIED;
}

}  // namespace

void FillSharedMemory(const PoolSession& pool, v1::SharedMemory* message) {
  const SharedBatchSlots& slots = *pool.shared_batch_slots();
  message->set_path(slots.path());
  message->set_size_bytes(slots.size_bytes());
  message->set_batch_count(slots.batch_count());
  message->set_batch_bytes(slots.layout().batch_bytes());
  const std::vector<int32_t> observation_shape = pool.options().observation_format.Shape();
  for (const SharedArray& facts : slots.layout().arrays()) {
    v1::SharedArray* array = message->add_arrays();
    array->set_field(std::string(facts.field));
    array->set_offset_bytes(facts.offset_bytes);
    array->set_element_type(ElementTypeOf(facts.element));
    array->add_shape(pool.env_count());
    if (facts.is_pictures) {
      array->mutable_shape()->Add(observation_shape.begin(), observation_shape.end());
    }
  }
}

void FillPipeTransport(const PipeListener& listener, const std::string& key,
                       v1::StepPoolResponse* response) {
  v1::PipeTransport* offer =
      response->mutable_attached()->mutable_shared_memory()->mutable_pipe_transport();
  offer->set_socket_name(listener.socket_name());
  offer->set_key(key);
}

Batch PrepareSharedResponse(const Request& request, const SharedBatchSlots& slots,
                            v1::StepPoolResponse* response) {
  response->set_sequence_number(request.sequence_number);
  v1::Batch* message = response->mutable_batch();
  message->set_first_env(request.first);
  message->set_env_count(request.count);
  message->set_last(true);
  message->set_shared_batch(request.shared_batch);
  message->set_shared_observations(request.with_observations);
  message->set_shared_final_observations(request.with_final_observations);
  Batch batch = slots.Rows(request.shared_batch, request.first, request.count);
  if (!request.with_observations) {
    batch.observations = {};
  }
  if (!request.with_final_observations) {
    batch.final_observations = {};
  }
  return batch;
}

}  // namespace procgen
