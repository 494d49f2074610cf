#ifndef PROCGEN_CLIENT_INTERNAL_RESPONSE_VALIDATOR_H_
#define PROCGEN_CLIENT_INTERNAL_RESPONSE_VALIDATOR_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "procgen/v1/step.pb.h"

namespace procgen_client {

// Validates the response to attach, so that sizes computed from it fit their types. Errors:
// INTERNAL; the message contains the value given and the value expected.
absl::Status ValidateAttached(const procgen::v1::Attach& attach,
                              const procgen::v1::Attached& attached);

// Validates the responses of a stream before they are read: their sequence numbers, order,
// environments, and the size of each array. A response that passes can be indexed by the request's
// own counts. Cost: a few comparisons for each response, and one pass over terminated and
// truncated. Threads: compatible.
class ResponseValidator {
 public:
  ResponseValidator() = default;
  // `shared_batch_count`: 0 without shared memory. REQUIRES: ValidateAttached(attached) is OK.
  ResponseValidator(const procgen::v1::Attached& attached, int32_t shared_batch_count);

  // Expects the responses to `request` from now on, starting with the first.
  void Expect(const procgen::v1::StepPoolRequest& request);

  // Validates the next response. Errors: DATA_LOSS; the message contains the value given and the
  // value expected. No further response may be validated then.
  absl::Status Validate(const procgen::v1::StepPoolResponse& response);

  // Whether the last validated response completes the answer.
  bool is_complete() const { return is_complete_; }

 private:
  absl::Status Wrong(absl::string_view what) const;
  absl::Status WrongSize(absl::string_view what, int64_t given, int64_t expected) const;
  absl::Status ValidateBatch(const procgen::v1::Batch& batch);
  absl::Status ValidateRange(const procgen::v1::Batch& batch) const;
  absl::Status ValidateArrays(const procgen::v1::Batch& batch) const;
  absl::Status ValidateObservations(const procgen::v1::Batch& batch, int64_t ended) const;
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
  int64_t next_environment_ = 0;  // the first without a response
  int64_t end_environment_ = 0;   // exclusive
  bool wants_ack_ = false;
  bool wants_observations_ = false;
  bool wants_final_observations_ = false;
  bool is_complete_ = false;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_RESPONSE_VALIDATOR_H_
