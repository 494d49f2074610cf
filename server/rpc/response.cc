#include "server/rpc/response.h"

#include <array>
#include <cstdint>

#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/wire_format_lite.h"

namespace procgen {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;

// Writes what stands before a field of `size` bytes: its number, its kind and its size; returns
// where it ends.
uint8_t* WriteHead(int field, size_t size, uint8_t* out) {
  out = WireFormatLite::WriteTagToArray(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED, out);
  return CodedOutputStream::WriteVarint32ToArray(static_cast<uint32_t>(size), out);
}

size_t HeadSize(int field, size_t size) {
  return WireFormatLite::TagSize(field, WireFormatLite::TYPE_BYTES) +
         CodedOutputStream::VarintSize32(static_cast<uint32_t>(size));
}

// All that stands before the observations: they are the last field of the batch, and the batch is
// that of the response.
grpc::Slice BytesBefore(const Response& response) {
  constexpr int kSequenceNumber = v1::StepPoolResponse::kSequenceNumberFieldNumber;
  constexpr int kBatch = v1::StepPoolResponse::kBatchFieldNumber;
  constexpr int kObservations = v1::Batch::kObservationsFieldNumber;
  const v1::Batch& batch = response.message.batch();
  const int64_t value = response.message.sequence_number();
  const size_t picture_bytes = response.observations.size();
  const size_t rows_bytes = batch.ByteSizeLong() + HeadSize(kObservations, picture_bytes);
  const size_t batch_bytes = rows_bytes + picture_bytes;
  const size_t number_bytes = WireFormatLite::TagSize(kSequenceNumber, WireFormatLite::TYPE_INT64) +
                              WireFormatLite::Int64Size(value);
  grpc::Slice bytes(number_bytes + HeadSize(kBatch, batch_bytes) + rows_bytes);
  // It is nobody else's yet; its type does not say so.
  auto* end = const_cast<uint8_t*>(bytes.begin());
  end = WireFormatLite::WriteInt64ToArray(kSequenceNumber, value, end);
  end = WriteHead(kBatch, batch_bytes, end);
  end = batch.SerializeWithCachedSizesToArray(end);
  WriteHead(kObservations, picture_bytes, end);
  return bytes;
}

}  // namespace

grpc::ByteBuffer Serialized(const Response& response) {
  if (response.observations.size() == 0) {
    const grpc::Slice bytes(response.message.SerializeAsString());
    return {&bytes, 1};
  }
  const std::array<grpc::Slice, 2> slices = {BytesBefore(response), response.observations};
  return {slices.data(), slices.size()};
}

}  // namespace procgen
