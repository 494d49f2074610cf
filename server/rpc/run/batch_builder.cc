#include "server/rpc/run/batch_builder.h"

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

// Resizes an array to `count` and returns its memory.
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

// An array of signed numbers, the fingerprints, stores the bits of unsigned ones.
absl::Span<uint64_t> Sized(google::protobuf::RepeatedField<int64_t>* array, int32_t count) {
  array->Resize(count, 0);
  return absl::MakeSpan(reinterpret_cast<uint64_t*>(array->mutable_data()),
                        static_cast<size_t>(count));
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

// Serialises a response with `batch` up to the observations, the last field, of `picture_bytes`.
grpc::Slice PrefixOf(const v1::Batch& batch, size_t picture_bytes) {
  constexpr int kBatch = v1::RunPoolResponse::kBatchFieldNumber;
  constexpr int kObservations = v1::Batch::kObservationsFieldNumber;
  const size_t rows_bytes = batch.ByteSizeLong() + FieldHeaderSize(kObservations, picture_bytes);
  const size_t batch_bytes = rows_bytes + picture_bytes;
  grpc::Slice bytes(FieldHeaderSize(kBatch, batch_bytes) + rows_bytes);
  // The slice is not shared yet, so writing through its const pointer is safe.
  auto* end = const_cast<uint8_t*>(bytes.begin());
  end = WriteFieldHeader(kBatch, batch_bytes, end);
  end = batch.SerializeWithCachedSizesToArray(end);
  WriteFieldHeader(kObservations, picture_bytes, end);
  return bytes;
}

// Moves the fingerprints and final observations of ended episodes to the front, and truncates the
// fields of `message`, which contain them.
void CompactEnded(size_t observation_bytes, const Batch& batch, v1::Batch* message) {
  uint8_t* const finals = batch.final_observations.data();
  const bool has_finals = !batch.final_observations.empty();
  size_t kept = 0;
  for (size_t row = 0; row < batch.terminated.size(); ++row) {
    if (batch.terminated[row] == 0 && batch.truncated[row] == 0) {
      continue;
    }
    batch.fingerprints[kept] = batch.fingerprints[row];
    if (has_finals && row != kept) {
      std::memcpy(finals + kept * observation_bytes, finals + row * observation_bytes,
                  observation_bytes);
    }
    ++kept;
  }
  message->mutable_fingerprints()->Truncate(static_cast<int>(kept));
  message->mutable_final_observations()->resize(has_finals ? kept * observation_bytes : 0);
}

}  // namespace

BatchBuilder::BatchBuilder(const PoolSession& pool)
    : observation_bytes_(pool.observation_bytes()),
      encoder_(pool.encoding() == Encoding::kRaw
                   ? nullptr
                   : std::make_unique<ObservationEncoder>(
                         pool.env_count(), static_cast<size_t>(pool.observation_bytes()))) {}

Batch BatchBuilder::Prepare(const Request& request) {
  const int64_t picture_bytes = request.count * observation_bytes_;
  v1::Batch* message = response_.mutable_batch();
  message->set_first_env(request.first);
  message->set_env_count(request.count);
#define PROCGEN_SIZE(type, name, member) \
  batch_.name = Sized(message->mutable_##name(), request.count);
  PROCGEN_BATCH_NUMBERS(PROCGEN_SIZE)
#undef PROCGEN_SIZE
  batch_.final_observations = Sized(message->mutable_final_observations(),
                                    request.with_final_observations ? picture_bytes : 0);
  Frames observations =
      frames_.Take(static_cast<size_t>(request.with_observations ? picture_bytes : 0));
  batch_.observations = observations.bytes;
  observations_ = std::move(observations.slice);
  return batch_;
}

grpc::ByteBuffer BatchBuilder::Finish() {
  v1::Batch* message = response_.mutable_batch();
  CompactEnded(static_cast<size_t>(observation_bytes_), batch_, message);
  grpc::Slice observations = std::exchange(observations_, grpc::Slice());
  if (observations.size() == 0) {
    return Serialized(response_);
  }
  if (encoder_ != nullptr) {
    observations = grpc::Slice(
        encoder_->Encode(message->first_env(), message->env_count(), batch_.observations));
  }
  const std::array<grpc::Slice, 2> slices = {PrefixOf(*message, observations.size()),
                                             std::move(observations)};
  return {slices.data(), slices.size()};
}

grpc::ByteBuffer Serialized(const v1::RunPoolResponse& response) {
  const grpc::Slice bytes(response.SerializeAsString());
  return {&bytes, 1};
}

}  // namespace procgen
