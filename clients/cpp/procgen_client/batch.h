#ifndef PROCGEN_CLIENT_BATCH_H_
#define PROCGEN_CLIENT_BATCH_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "procgen/v1/step.pb.h"
#include "procgen_client/observation_decoder.h"
#include "procgen_client/shared_mapping.h"

namespace procgen_client {

// The answer to one request: how n environments stand. Row i is environment first_env() +
// i. The comments of procgen.v1.Batch tell what each value means.
// F is the shape of one observation, StepStream::pool().observation_shape(), by default 64, 64, 3.
// The spans are good until the Batch is filled again or ends. An answer that came in one response
// is not copied; observations that came encoded are decoded. Of a pool that shares memory the spans
// point there, and the server writes that part of it again only when the Batch, and what was copied
// of it, is filled again or has ended; so hold no more of them than StreamOptions::held_batches_max
// allows.
// Threads: compatible (one at a time).
class Batch {
 public:
  int64_t sequence_number() const { return response_.sequence_number(); }
  int32_t first_env() const { return first_env_; }
  int32_t env_count() const { return value().env_count(); }

  absl::Span<const uint8_t> observations() const {
    return Shared(&SharedRows::observations,
                  decoded_.empty() ? Bytes(value().observations()) : absl::MakeConstSpan(decoded_));
  }
  //                                                          uint8  [n, F], or empty
  absl::Span<const float> rewards() const {
    return Shared(&SharedRows::rewards, Numbers(value().rewards()));
  }  // [n]
  absl::Span<const bool> first() const {
    return Shared(&SharedRows::first, Numbers(value().first()));
  }  // [n]
  absl::Span<const bool> terminated() const {
    return Shared(&SharedRows::terminated, Numbers(value().terminated()));
  }  // [n]
  absl::Span<const bool> truncated() const {
    return Shared(&SharedRows::truncated, Numbers(value().truncated()));
  }  // [n]
  absl::Span<const int32_t> level_seeds() const {
    return Shared(&SharedRows::level_seeds, Numbers(value().level_seeds()));
  }                                                     // [n]
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
  // Hashes of the ended episodes, of the m rows with terminated or truncated, in order. The
  // contract sends their 64 bits as signed numbers. Of a server without them
  // (Features.fingerprints) there are none.
  absl::Span<const uint64_t> fingerprints() const {  // [m], or empty
    const absl::Span<const int64_t> numbers = Numbers(value().fingerprints());
    return Shared(
        &SharedRows::fingerprints,
        absl::MakeConstSpan(reinterpret_cast<const uint64_t*>(numbers.data()), numbers.size()));
  }
  absl::Span<const uint8_t> final_observations() const {
    return Shared(&SharedRows::final_observations, Bytes(value().final_observations()));
  }  //                                                       uint8  [m, F], or empty

  // Has done with what it shows of shared memory, which is empty from now on: the server may write
  // there again from the next request on. Otherwise it may with the request after that, as the next
  // answer is received before it, so that one batch more goes in and out of the caches.
  void Release() { shared_ = nullptr; }

 private:
  friend class StepStream;

  // The rows of one response, and what it bears of observations.
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
  // An array where it lies: in shared memory, or as the message has it.
  template <typename Element>
  absl::Span<const Element> Shared(absl::Span<const Element> SharedRows::*array,
                                   absl::Span<const Element> received) const {
    return shared_ == nullptr ? received : (*shared_).*array;
  }

  // Begins with the first response of an answer; then adds the others' rows. All are valid
  // (ResponseValidator).
  void Begin();
  void Append(const procgen::v1::Batch& part);
  // Decodes the observations of the whole answer; `decoder` null: they are as they came. Errors:
  // DATA_LOSS they are no observations of the pool, or do not follow what was decoded before.
  absl::Status Decode(ObservationDecoder* decoder);

  procgen::v1::StepPoolResponse response_;  // the first of the answer; others' rows are appended
  int32_t first_env_ = 0;
  std::shared_ptr<const SharedRows> shared_;  // null: the values came in the responses
  std::vector<Part> parts_;
  std::vector<uint8_t> decoded_;  // [n, F]; empty: they came as they are, or none did
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_BATCH_H_
