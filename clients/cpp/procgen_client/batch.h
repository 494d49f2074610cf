#ifndef PROCGEN_CLIENT_BATCH_H_
#define PROCGEN_CLIENT_BATCH_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "procgen/v1/step.pb.h"
#include "procgen_client/internal/shared_mapping.h"
#include "procgen_client/observation_decoder.h"

namespace procgen_client {

// The answer to one request: the values of n environments. Row i is environment first_env() + i.
// procgen.v1.Batch documents each value. F is the shape of one observation,
// StepStream::pool().observation_shape(), by default 64, 64, 3.
//
// Spans are valid until the Batch is reused or destroyed. An answer in one response is not copied.
// Encoded observations are decoded.
//
// With shared memory the spans point there. The server does not overwrite a batch while this Batch
// or a copy of it refers to it. StreamOptions::held_batches_max bounds how many can be held.
// Threads: compatible (one at a time).
class Batch {
 public:
  int64_t sequence_number() const { return response_.sequence_number(); }
  int32_t first_env() const { return first_env_; }
  int32_t env_count() const { return value().env_count(); }

  // [n, F]; empty with OBSERVATION_NONE.
  absl::Span<const uint8_t> observations() const {
    return Shared(&SharedRows::observations,
                  decoded_.empty() ? Bytes(value().observations()) : absl::MakeConstSpan(decoded_));
  }
  absl::Span<const float> rewards() const {  // [n]
    return Shared(&SharedRows::rewards, Numbers(value().rewards()));
  }
  absl::Span<const bool> first() const {  // [n]
    return Shared(&SharedRows::first, Numbers(value().first()));
  }
  absl::Span<const bool> terminated() const {  // [n]
    return Shared(&SharedRows::terminated, Numbers(value().terminated()));
  }
  absl::Span<const bool> truncated() const {  // [n]
    return Shared(&SharedRows::truncated, Numbers(value().truncated()));
  }
  absl::Span<const int32_t> level_seeds() const {  // [n]
    return Shared(&SharedRows::level_seeds, Numbers(value().level_seeds()));
  }
  absl::Span<const int32_t> prev_level_seeds() const {  // [n]
    return Shared(&SharedRows::prev_level_seeds, Numbers(value().prev_level_seeds()));
  }
  absl::Span<const bool> prev_level_complete() const {  // [n]
    return Shared(&SharedRows::prev_level_complete, Numbers(value().prev_level_complete()));
  }
  absl::Span<const float> episode_returns() const {  // [n]
    return Shared(&SharedRows::episode_returns, Numbers(value().episode_returns()));
  }
  absl::Span<const int32_t> episode_lengths() const {  // [n]
    return Shared(&SharedRows::episode_lengths, Numbers(value().episode_lengths()));
  }
  // [m], hashes of the ended episodes, for the m rows with terminated or truncated set, in order.
  // Empty if the server has none (Features.fingerprints).
  absl::Span<const uint64_t> fingerprints() const {
    const absl::Span<const int64_t> numbers = Numbers(value().fingerprints());
    return Shared(
        &SharedRows::fingerprints,
        absl::MakeConstSpan(reinterpret_cast<const uint64_t*>(numbers.data()), numbers.size()));
  }
  // [m, F]; empty unless requested.
  absl::Span<const uint8_t> final_observations() const {
    return Shared(&SharedRows::final_observations, Bytes(value().final_observations()));
  }

  // Releases the batch of shared memory early; spans into it are empty afterwards. The server may
  // then overwrite it from the next request on, in place of one request later. A learner that
  // sends ahead thus uses two batches in place of three, which fit the caches better.
  void Release() { shared_ = nullptr; }

 private:
  friend class StepStream;

  // Rows of one response, and its bytes of observations.
  struct Part {
    int32_t first_env = 0;
    int32_t env_count = 0;
    size_t observation_bytes = 0;
  };

  template <typename Number>
  static absl::Span<const Number> Numbers(const google::protobuf::RepeatedField<Number>& array) {
    return absl::MakeConstSpan(array.data(), static_cast<size_t>(array.size()));
  }
  static absl::Span<const uint8_t> Bytes(const std::string& bytes) {
    return absl::MakeConstSpan(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  }
  const procgen::v1::Batch& value() const { return response_.batch(); }
  // The array in shared memory if there is one, otherwise the one in the message.
  template <typename Element>
  absl::Span<const Element> Shared(absl::Span<const Element> SharedRows::*array,
                                   absl::Span<const Element> received) const {
    return shared_ == nullptr ? received : (*shared_).*array;
  }

  // Starts with the first response of an answer.
  // REQUIRES (as Append): ResponseValidator has accepted the response.
  void Begin();
  // Appends the rows of a further response.
  void Append(const procgen::v1::Batch& part);
  // Decodes the observations of the whole answer; null `decoder`: they are not encoded. Errors:
  // DATA_LOSS malformed bytes, or a gap after what was decoded before.
  absl::Status Decode(ObservationDecoder* decoder);

  procgen::v1::StepPoolResponse response_;  // the first response; rows of others are appended
  int32_t first_env_ = 0;
  std::shared_ptr<const SharedRows> shared_;  // null: the responses contain the values
  std::vector<Part> parts_;
  std::vector<uint8_t> decoded_;  // [n, F]; empty without encoded observations
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_BATCH_H_
