#include "server/rpc/step/response.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

#include "absl/types/span.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/wire_format_lite.h"

namespace procgen {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;

// Resizes an array to `count` zeros and returns its memory.
template <typename Number>
absl::Span<Number> Sized(google::protobuf::RepeatedField<Number>* array, int32_t count) {
  array->Resize(count, Number());
  return absl::MakeSpan(array->mutable_data(), static_cast<size_t>(count));
}

absl::Span<uint8_t> Sized(google::protobuf::RepeatedField<bool>* array, int32_t count) {
  static_assert(sizeof(bool) == 1);
  array->Resize(count, false);
  return absl::MakeSpan(reinterpret_cast<uint8_t*>(array->mutable_data()),
                        static_cast<size_t>(count));
}

// The same for an array of signed numbers that stores the bits of unsigned ones.
absl::Span<uint64_t> SizedBits(google::protobuf::RepeatedField<int64_t>* array, int32_t count) {
  const absl::Span<int64_t> numbers = Sized(array, count);
  return absl::MakeSpan(reinterpret_cast<uint64_t*>(numbers.data()), numbers.size());
}

absl::Span<uint8_t> Sized(std::string* bytes, int64_t size) {
  bytes->resize(static_cast<size_t>(size));
  return absl::MakeSpan(reinterpret_cast<uint8_t*>(bytes->data()), bytes->size());
}

// Writes the tag and the length of a field of `size` bytes. Returns the end of the written bytes.
uint8_t* WriteFieldHeader(int field, size_t size, uint8_t* out) {
  out = WireFormatLite::WriteTagToArray(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED, out);
  return CodedOutputStream::WriteVarint32ToArray(static_cast<uint32_t>(size), out);
}

size_t FieldHeaderSize(int field, size_t size) {
  return WireFormatLite::TagSize(field, WireFormatLite::TYPE_BYTES) +
         CodedOutputStream::VarintSize32(static_cast<uint32_t>(size));
}

// Serialises everything before the observations, which are the last field of the batch, as the
// batch is of the response.
grpc::Slice PrefixOf(const Response& response) {
  constexpr int kSequenceNumber = v1::StepPoolResponse::kSequenceNumberFieldNumber;
  constexpr int kBatch = v1::StepPoolResponse::kBatchFieldNumber;
  constexpr int kObservations = v1::Batch::kObservationsFieldNumber;
  const v1::Batch& batch = response.message.batch();
  const int64_t value = response.message.sequence_number();
  const size_t picture_bytes = response.observations.size();
  const size_t rows_bytes = batch.ByteSizeLong() + FieldHeaderSize(kObservations, picture_bytes);
  const size_t batch_bytes = rows_bytes + picture_bytes;
  const size_t number_bytes = WireFormatLite::TagSize(kSequenceNumber, WireFormatLite::TYPE_INT64) +
                              WireFormatLite::Int64Size(value);
  grpc::Slice bytes(number_bytes + FieldHeaderSize(kBatch, batch_bytes) + rows_bytes);
  // The slice is not shared yet, so writing through its const pointer is safe.
  auto* end = const_cast<uint8_t*>(bytes.begin());
  end = WireFormatLite::WriteInt64ToArray(kSequenceNumber, value, end);
  end = WriteFieldHeader(kBatch, batch_bytes, end);
  end = batch.SerializeWithCachedSizesToArray(end);
  WriteFieldHeader(kObservations, picture_bytes, end);
  return bytes;
}

}  // namespace

Batch PrepareResponse(const Request& request, Part part, int64_t observation_bytes,
                      FrameBufferPool* frames, Response* response) {
  response->message.set_sequence_number(request.sequence_number);
  if (request.kind == Request::Kind::kSample) {
    response->message.mutable_ack();
    return {};
  }
  const int64_t picture_bytes = part.count * observation_bytes;
  const int32_t slice_end = request.first + request.count;
  v1::Batch* message = response->message.mutable_batch();
  message->set_first_env(part.first);
  message->set_env_count(part.count);
  message->set_last(part.first + part.count == slice_end);
  Batch batch;
  batch.rewards = Sized(message->mutable_rewards(), part.count);
  batch.first = Sized(message->mutable_first(), part.count);
  batch.terminated = Sized(message->mutable_terminated(), part.count);
  batch.truncated = Sized(message->mutable_truncated(), part.count);
  batch.level_seeds = Sized(message->mutable_level_seeds(), part.count);
  batch.prev_level_seeds = Sized(message->mutable_prev_level_seeds(), part.count);
  batch.prev_level_complete = Sized(message->mutable_prev_level_complete(), part.count);
  batch.episode_returns = Sized(message->mutable_episode_returns(), part.count);
  batch.episode_lengths = Sized(message->mutable_episode_lengths(), part.count);
  batch.fingerprints = SizedBits(message->mutable_fingerprints(), part.count);
  batch.final_observations = Sized(message->mutable_final_observations(),
                                   request.with_final_observations ? picture_bytes : 0);
  response->observations = grpc::Slice();  // returns to `frames` before the next Take
  Frames observations =
      frames->Take(static_cast<size_t>(request.with_observations ? picture_bytes : 0));
  batch.observations = observations.bytes;
  response->observations = std::move(observations.slice);
  return batch;
}

void CompleteResponse(int64_t observation_bytes, const Batch& batch,
                      v1::StepPoolResponse* response) {
  const auto picture_bytes = static_cast<size_t>(observation_bytes);
  uint8_t* const pictures = batch.final_observations.data();
  const bool has_pictures = !batch.final_observations.empty();
  size_t kept = 0;
  for (size_t row = 0; row < batch.terminated.size(); ++row) {
    if (batch.terminated[row] == 0 && batch.truncated[row] == 0) {
      continue;
    }
    batch.fingerprints[kept] = batch.fingerprints[row];
    if (has_pictures && row != kept) {
      std::memcpy(pictures + kept * picture_bytes, pictures + row * picture_bytes, picture_bytes);
    }
    ++kept;
  }
  if (response->has_batch() && !response->batch().has_shared_batch()) {
    v1::Batch* message = response->mutable_batch();
    message->mutable_fingerprints()->Truncate(static_cast<int>(kept));
    message->mutable_final_observations()->resize(has_pictures ? kept * picture_bytes : 0);
  }
}

grpc::ByteBuffer Serialized(const Response& response) {
  if (response.observations.size() == 0) {
    const grpc::Slice bytes(response.message.SerializeAsString());
    return {&bytes, 1};
  }
  const std::array<grpc::Slice, 2> slices = {PrefixOf(response), response.observations};
  return {slices.data(), slices.size()};
}

}  // namespace procgen
