#include "server/rpc/response.h"

#include <array>
#include <cstdint>
#include <string>

#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"
#include "google/protobuf/wire_format_lite.h"

namespace procgen {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;

// What stands before a field of `size` bytes: its number, its kind and its size.
void WriteHead(int field, size_t size, CodedOutputStream* out) {
  WireFormatLite::WriteTag(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED, out);
  out->WriteVarint32(static_cast<uint32_t>(size));
}

size_t HeadSize(int field, size_t size) {
  return WireFormatLite::TagSize(field, WireFormatLite::TYPE_BYTES) +
         CodedOutputStream::VarintSize32(static_cast<uint32_t>(size));
}

// All that stands before the observations: they are the last field of the batch, and the batch is
// that of the response.
std::string BytesBefore(const Response& response) {
  constexpr int kObservations = v1::Batch::kObservationsFieldNumber;
  const v1::Batch& batch = response.message.batch();
  const size_t picture_bytes = response.observations.size();
  const size_t batch_bytes =
      batch.ByteSizeLong() + HeadSize(kObservations, picture_bytes) + picture_bytes;
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  CodedOutputStream out(&stream);
  WireFormatLite::WriteInt64(v1::StepPoolResponse::kSequenceNumberFieldNumber,
                             response.message.sequence_number(), &out);
  WriteHead(v1::StepPoolResponse::kBatchFieldNumber, batch_bytes, &out);
  batch.SerializeWithCachedSizes(&out);
  WriteHead(kObservations, picture_bytes, &out);
  out.Trim();
  return bytes;
}

}  // namespace

grpc::ByteBuffer Serialized(const Response& response) {
  if (response.observations.size() == 0) {
    const grpc::Slice bytes(response.message.SerializeAsString());
    return {&bytes, 1};
  }
  const std::array<grpc::Slice, 2> slices = {grpc::Slice(BytesBefore(response)),
                                             response.observations};
  return {slices.data(), slices.size()};
}

}  // namespace procgen
