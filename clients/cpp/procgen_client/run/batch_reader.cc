#include "procgen_client/run/batch_reader.h"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/wire_format_lite.h"
#include "grpcpp/support/proto_buffer_reader.h"
#include "procgen/v1/run.pb.h"

namespace procgen_client {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;
using Message = procgen::v1::Batch;

constexpr size_t kEncodedOverhead = 4096;

// Reads a packed array of exactly `count` numbers of fixed size (or bools, a byte each) to `array`;
// skips it if `array` is empty.
template <typename Number>
bool ReadArray(CodedInputStream* input, size_t count, absl::Span<Number> array) {
  uint32_t bytes = 0;
  if (!input->ReadVarint32(&bytes) || bytes != count * sizeof(Number)) {
    return false;
  }
  return array.empty() ? input->Skip(static_cast<int>(bytes))
                       : input->ReadRaw(array.data(), static_cast<int>(bytes));
}

// The same for an array of at most `count_max` elements of `element_bytes`, into `array`.
template <typename Array>
bool ReadUpTo(CodedInputStream* input, size_t bytes_max, Array* array) {
  using Element = typename Array::value_type;
  uint32_t bytes = 0;
  if (!input->ReadVarint32(&bytes) || bytes > bytes_max || bytes % sizeof(Element) != 0) {
    return false;
  }
  array->resize(bytes / sizeof(Element));
  return bytes == 0 || input->ReadRaw(array->data(), static_cast<int>(bytes));
}

bool ReadInt32(CodedInputStream* input, int32_t* number) {
  uint64_t value = 0;
  const bool is_there = input->ReadVarint64(&value);
  *number = static_cast<int32_t>(value);
  return is_there;
}

absl::Status Malformed(absl::string_view what) {
  return absl::DataLossError(absl::StrCat("the server's batch is malformed: ", what));
}

// A batch with memory for everything that is read.
struct Arrays {
  procgen::Batch batch;
  std::vector<uint64_t>* fingerprints;
  std::vector<uint8_t>* finals;
  std::string* encoded;  // null: observations are raw
};

// Reads the fields of a batch.
class FieldReader {
 public:
  FieldReader(const BatchShape& shape, const Arrays& arrays, CodedInputStream* input)
      : shape_(shape), arrays_(arrays), input_(input) {}

  absl::Status Read() {
    for (uint32_t tag = input_->ReadTag(); tag != 0; tag = input_->ReadTag()) {
      if (!ReadField(tag)) {
        return Malformed(absl::StrCat("field ", WireFormatLite::GetTagFieldNumber(tag)));
      }
    }
    // All but the fingerprints, which only rows with an ended episode have.
    constexpr int kRowArrayCount = static_cast<int>(std::size(procgen::kBatchNumberBytes)) - 1;
    if (first_env_ != shape_.first || env_count_ != shape_.count ||
        row_array_count_ != kRowArrayCount) {
      return Malformed(absl::StrCat("environments from ", first_env_, ", ", env_count_,
                                    " rows and ", row_array_count_, " arrays; expected from ",
                                    shape_.first, ", ", shape_.count, " and ", kRowArrayCount));
    }
    if (!arrays_.batch.observations.empty() && !has_observations_) {
      return Malformed("it has no observations");
    }
    return absl::OkStatus();
  }

  bool has_observations() const { return has_observations_; }

 private:
  bool ReadField(uint32_t tag) {
    const procgen::Batch& batch = arrays_.batch;
    switch (WireFormatLite::GetTagFieldNumber(tag)) {
      case Message::kFirstEnvFieldNumber:
        return ReadInt32(input_, &first_env_);
      case Message::kEnvCountFieldNumber:
        return ReadInt32(input_, &env_count_);
      case Message::kRewardsFieldNumber:
        return ReadRows(batch.rewards);
      case Message::kFirstFieldNumber:
        return ReadRows(batch.first);
      case Message::kTerminatedFieldNumber:
        return ReadRows(batch.terminated);
      case Message::kTruncatedFieldNumber:
        return ReadRows(batch.truncated);
      case Message::kLevelSeedsFieldNumber:
        return ReadRows(batch.level_seeds);
      case Message::kPrevLevelSeedsFieldNumber:
        return ReadRows(batch.prev_level_seeds);
      case Message::kPrevLevelCompleteFieldNumber:
        return ReadRows(batch.prev_level_complete);
      case Message::kEpisodeReturnsFieldNumber:
        return ReadRows(batch.episode_returns);
      case Message::kEpisodeLengthsFieldNumber:
        return ReadRows(batch.episode_lengths);
      case Message::kFingerprintsFieldNumber:
        return ReadUpTo(input_, rows() * sizeof(uint64_t), arrays_.fingerprints);
      case Message::kFinalObservationsFieldNumber:
        return ReadUpTo(input_, observations_bytes(), arrays_.finals);
      case Message::kObservationsFieldNumber:
        has_observations_ = true;
        return arrays_.encoded == nullptr
                   ? ReadArray(input_, observations_bytes(), batch.observations)
                   : ReadUpTo(input_, 2 * observations_bytes() + kEncodedOverhead, arrays_.encoded);
      default:
        return WireFormatLite::SkipField(input_, tag);
    }
  }

  template <typename Number>
  bool ReadRows(absl::Span<Number> array) {
    ++row_array_count_;
    return ReadArray(input_, rows(), array);
  }

  size_t rows() const { return static_cast<size_t>(shape_.count); }
  size_t observations_bytes() const { return rows() * shape_.observation_bytes; }

  const BatchShape& shape_;
  const Arrays& arrays_;
  CodedInputStream* const input_;
  int32_t first_env_ = 0;
  int32_t env_count_ = 0;
  int row_array_count_ = 0;
  bool has_observations_ = false;
};

// Gives fingerprints and final observations, which have a row for each ended episode, their rows.
void SpreadEnded(const BatchShape& shape, const Arrays& arrays) {
  const procgen::Batch& batch = arrays.batch;
  const size_t bytes = shape.observation_bytes;
  std::fill(batch.fingerprints.begin(), batch.fingerprints.end(), 0);
  size_t ended = 0;
  for (size_t row = 0; row < batch.terminated.size(); ++row) {
    if (batch.terminated[row] == 0 && batch.truncated[row] == 0) {
      continue;
    }
    if (ended < arrays.fingerprints->size()) {
      batch.fingerprints[row] = (*arrays.fingerprints)[ended];
    }
    if ((ended + 1) * bytes <= arrays.finals->size() && !batch.final_observations.empty()) {
      std::memcpy(&batch.final_observations[row * bytes], arrays.finals->data() + ended * bytes,
                  bytes);
    }
    ++ended;
  }
}

}  // namespace

absl::Status BatchReader::Read(grpc::ByteBuffer response, const BatchShape& shape,
                               const procgen::Batch& batch, ObservationDecoder* decoder) {
  const Arrays arrays = {.batch = batch,
                         .fingerprints = &fingerprints_,
                         .finals = &finals_,
                         .encoded = decoder == nullptr ? nullptr : &encoded_};
  fingerprints_.clear();
  finals_.clear();

  grpc::ProtoBufferReader reader(&response);
  CodedInputStream input(&reader);
  const uint32_t batch_tag = WireFormatLite::MakeTag(
      procgen::v1::RunPoolResponse::kBatchFieldNumber, WireFormatLite::WIRETYPE_LENGTH_DELIMITED);
  uint32_t batch_bytes = 0;
  if (input.ReadTag() != batch_tag || !input.ReadVarint32(&batch_bytes)) {
    return Malformed("it is none");
  }
  const CodedInputStream::Limit limit = input.PushLimit(static_cast<int>(batch_bytes));
  FieldReader fields(shape, arrays, &input);
  if (absl::Status status = fields.Read(); !status.ok()) {
    return status;
  }
  if (!input.CheckEntireMessageConsumedAndPopLimit(limit)) {
    return Malformed("it is cut off");
  }
  if (decoder != nullptr && fields.has_observations()) {
    if (absl::Status status =
            decoder->Decode(shape.first, shape.count, encoded_, batch.observations);
        !status.ok()) {
      return status;
    }
  }
  SpreadEnded(shape, arrays);
  return absl::OkStatus();
}

}  // namespace procgen_client
