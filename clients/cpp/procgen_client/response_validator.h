#ifndef PROCGEN_CLIENT_RESPONSE_VALIDATOR_H_
#define PROCGEN_CLIENT_RESPONSE_VALIDATOR_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "procgen/v1/step.pb.h"

namespace procgen_client {

// Validates what a server says of the pool that a stream attached to, so that sizes computed from
// it fit their types. Errors: INTERNAL (the message says what was given and what was expected).
absl::Status ValidateAttached(const procgen::v1::Attach& attach,
                              const procgen::v1::Attached& attached);

// Validates the responses to one request after the other before anything of them is read: their
// numbers, their order, the environments that they cover, and the size of each array. A response
// that passes can be read by the request's own counts, whatever server sent it.
// Cost: some comparisons a response, and one pass over the flags of ends.
// Threads: compatible.
class ResponseValidator {
 public:
  ResponseValidator() = default;
  // REQUIRES: `attached` is valid. `shared_batch_count`: 0, the pool shares no memory.
  ResponseValidator(const procgen::v1::Attached& attached, int32_t shared_batch_count);

  // Expects the responses to `request` from now on, the first of them next.
  void Expect(const procgen::v1::StepPoolRequest& request);

  // Validates the next response. Errors: DATA_LOSS (the message says what was given and what was
  // expected); no further response may follow.
  absl::Status Validate(const procgen::v1::StepPoolResponse& response);

  // Whether the last response that was validated ends the answer.
  bool is_complete() const { return is_complete_; }

 private:
  absl::Status Wrong(absl::string_view what) const;
  absl::Status WrongSize(absl::string_view what, int64_t given, int64_t expected) const;
  absl::Status ValidateBatch(const procgen::v1::Batch& batch);
  absl::Status ValidateRange(const procgen::v1::Batch& batch) const;
  absl::Status ValidateArrays(const procgen::v1::Batch& batch) const;
  absl::Status ValidatePictures(const procgen::v1::Batch& batch, int64_t ended) const;
  absl::Status ValidateShared(const procgen::v1::Batch& batch) const;

  // Of the pool.
  int64_t env_count_ = 0;
  int64_t observation_bytes_ = 0;
  int64_t response_bytes_max_ = 0;
  int32_t shared_batch_count_ = 0;
  bool is_encoded_ = false;
  bool is_same_step_ = false;  // AUTORESET_MODE_SAME_STEP

  // Of the request.
  int64_t sequence_number_ = 0;
  int64_t next_environment_ = 0;  // the first that no response has covered
  int64_t end_environment_ = 0;   // exclusive
  bool wants_ack_ = false;
  bool wants_observations_ = false;
  bool wants_final_observations_ = false;
  bool is_complete_ = false;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_RESPONSE_VALIDATOR_H_
