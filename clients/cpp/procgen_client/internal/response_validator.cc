#include "procgen_client/internal/response_validator.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "procgen_client/internal/answer_validation.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

constexpr int64_t kResponseBytesDefault = 4194304;  // Attach.response_bytes_max 0

absl::Status WrongAttached(absl::string_view what) {
  return absl::InternalError(absl::StrCat("the server's answer to attach: ", what));
}

// End of a slice, exclusive; env_count 0 extends it to the end of the pool.
int64_t SliceEnd(const v1::Slice& slice, int64_t env_count) {
  return slice.env_count() == 0 ? env_count : int64_t{slice.first_env()} + slice.env_count();
}

bool WantsObservations(v1::Observation observation) { return observation != v1::OBSERVATION_NONE; }

}  // namespace

absl::Status ValidateAttached(const v1::Attach& attach, const v1::Attached& attached) {
  if (absl::Status status = ValidatePool(attached.pool(), attach.pool()); !status.ok()) {
    return status;
  }
  if (attached.requests_in_flight_max() < 1) {
    return WrongAttached(absl::StrCat(attached.requests_in_flight_max(),
                                      " requests in flight, expected: at least 1"));
  }
  const int64_t bytes_max =
      attach.response_bytes_max() == 0 ? kResponseBytesDefault : attach.response_bytes_max();
  if (attached.response_bytes_max() < 1 || attached.response_bytes_max() > bytes_max) {
    return WrongAttached(absl::StrCat("responses of ", attached.response_bytes_max(),
                                      " bytes, expected: 1 to ", bytes_max));
  }
  if (attached.next_sequence_number() < 1 || attached.oldest_kept_sequence_number() < 0 ||
      attached.oldest_kept_sequence_number() > attached.next_sequence_number()) {
    return WrongAttached(absl::StrCat("next request ", attached.next_sequence_number(),
                                      ", oldest kept ", attached.oldest_kept_sequence_number(),
                                      ", expected: 1 or more, and no more than that"));
  }
  const bool shares = attached.pool().spec().transport() == v1::TRANSPORT_SHARED_MEMORY;
  if (shares != attached.has_shared_memory()) {
    return WrongAttached(shares ? "no shared memory, expected: that of the pool's transport"
                                : "shared memory, expected: none with the pool's transport");
  }
  return absl::OkStatus();
}

ResponseValidator::ResponseValidator(const v1::Attached& attached, int32_t shared_batch_count)
    : env_count_(attached.pool().spec().env_count()),
      observation_bytes_(attached.pool().observation_bytes()),
      response_bytes_max_(attached.response_bytes_max()),
      shared_batch_count_(shared_batch_count) {
  const v1::Encoding encoding = attached.pool().spec().encoding();
  is_encoded_ = encoding != v1::ENCODING_UNSPECIFIED && encoding != v1::ENCODING_RAW;
  const v1::AutoresetMode mode = attached.pool().spec().autoreset_mode();
  is_same_step_ = mode == v1::AUTORESET_MODE_UNSPECIFIED || mode == v1::AUTORESET_MODE_SAME_STEP;
}

void ResponseValidator::Expect(const v1::StepPoolRequest& request) {
  sequence_number_ = request.sequence_number();
  is_complete_ = false;
  wants_ack_ = request.has_level_sampler();
  wants_final_observations_ = false;
  if (request.has_step()) {
    const v1::Step& step = request.step();
    next_environment_ = step.slice().first_env();
    end_environment_ = next_environment_ + step.actions_size();
    wants_observations_ = WantsObservations(step.observation());
    wants_final_observations_ = step.with_final_observations();
  } else if (request.has_reset()) {
    next_environment_ = request.reset().slice().first_env();
    end_environment_ = SliceEnd(request.reset().slice(), env_count_);
    wants_observations_ = WantsObservations(request.reset().observation());
  } else {
    next_environment_ = request.observe().slice().first_env();
    end_environment_ = SliceEnd(request.observe().slice(), env_count_);
    wants_observations_ = WantsObservations(request.observe().observation());
  }
  end_environment_ = std::min(end_environment_, env_count_);
}

absl::Status ResponseValidator::Validate(const v1::StepPoolResponse& response) {
  if (response.sequence_number() != sequence_number_) {
    return Wrong(
        absl::StrCat("number ", response.sequence_number(), ", expected: ", sequence_number_));
  }
  if (wants_ack_ ? !response.has_ack() : !response.has_batch()) {
    return Wrong(absl::StrCat("a response of kind ", static_cast<int>(response.response_case()),
                              ", expected: ",
                              wants_ack_ ? v1::StepPoolResponse::kAckFieldNumber
                                         : v1::StepPoolResponse::kBatchFieldNumber));
  }
  if (wants_ack_) {
    is_complete_ = true;
    return absl::OkStatus();
  }
  return ValidateBatch(response.batch());
}

absl::Status ResponseValidator::Wrong(absl::string_view what) const {
  return absl::DataLossError(
      absl::StrCat("the server's answer to request ", sequence_number_, ": ", what));
}

absl::Status ResponseValidator::WrongSize(absl::string_view what, int64_t given,
                                          int64_t expected) const {
  return Wrong(absl::StrCat(what, " of size ", given, ", expected: ", expected));
}

absl::Status ResponseValidator::ValidateBatch(const v1::Batch& batch) {
  absl::Status status = ValidateRange(batch);
  if (status.ok()) {
    status = shared_batch_count_ > 0 ? ValidateShared(batch) : ValidateArrays(batch);
  }
  if (status.ok()) {
    next_environment_ += batch.env_count();
    is_complete_ = batch.last();
  }
  return status;
}

absl::Status ResponseValidator::ValidateRange(const v1::Batch& batch) const {
  const int64_t count_max = end_environment_ - next_environment_;
  const int64_t count = batch.env_count();
  if (batch.first_env() != next_environment_ || next_environment_ < 0 || count < 1 ||
      count > count_max) {
    return Wrong(absl::StrCat(count, " environments from ", batch.first_env(), ", expected: 1 to ",
                              count_max, " from ", next_environment_));
  }
  if (batch.last() != (count == count_max)) {
    return Wrong(absl::StrCat("environments ", batch.first_env(), " to ",
                              batch.first_env() + count - 1,
                              batch.last() ? " as the last, expected: up to "
                                           : " as not the last, expected: the last with ",
                              end_environment_ - 1));
  }
  return absl::OkStatus();
}

absl::Status ResponseValidator::ValidateArrays(const v1::Batch& batch) const {
  if (batch.has_shared_batch()) {
    return Wrong(absl::StrCat("batch ", batch.shared_batch(),
                              " of shared memory, expected: none, as the pool shares no memory"));
  }
  const int count = batch.env_count();
  const std::pair<absl::string_view, int> sizes[] = {
      {"rewards", batch.rewards_size()},
      {"first", batch.first_size()},
      {"terminated", batch.terminated_size()},
      {"truncated", batch.truncated_size()},
      {"level_seeds", batch.level_seeds_size()},
      {"prev_level_seeds", batch.prev_level_seeds_size()},
      {"prev_level_complete", batch.prev_level_complete_size()},
      {"episode_returns", batch.episode_returns_size()},
      {"episode_lengths", batch.episode_lengths_size()},
  };
  for (const auto& [field, size] : sizes) {
    if (size != count) {
      return WrongSize(field, size, count);
    }
  }
  const bool* const terminated = batch.terminated().data();
  const bool* const truncated = batch.truncated().data();
  int64_t ended = 0;
  for (int row = 0; row < count; ++row) {
    ended += terminated[row] || truncated[row] ? 1 : 0;
  }
  // A server without fingerprints (Features.fingerprints) sends none.
  if (batch.fingerprints_size() != ended && batch.fingerprints_size() != 0) {
    return WrongSize("fingerprints", batch.fingerprints_size(), ended);
  }
  return ValidateObservations(batch, ended);
}

absl::Status ResponseValidator::ValidateObservations(const v1::Batch& batch, int64_t ended) const {
  const auto final_bytes = static_cast<int64_t>(batch.final_observations().size());
  const int64_t expected_final = wants_final_observations_ ? ended * observation_bytes_ : 0;
  // In other modes `observations` contains the final one, and the server may omit the second copy.
  const bool may_be_absent = !is_same_step_ && final_bytes == 0;
  if (final_bytes != expected_final && !may_be_absent) {
    return WrongSize("final_observations", final_bytes, expected_final);
  }
  const auto bytes = static_cast<int64_t>(batch.observations().size());
  const int64_t decoded = batch.env_count() * observation_bytes_;
  if (!is_encoded_ || !wants_observations_) {
    const int64_t expected = wants_observations_ ? decoded : 0;
    return bytes == expected ? absl::OkStatus() : WrongSize("observations", bytes, expected);
  }
  if (bytes == 0) {
    return Wrong("no observations, expected: encoded ones");
  }
  // The server sizes responses by raw observations, so the decoded size is bounded, too.
  if (decoded > response_bytes_max_) {
    return Wrong(absl::StrCat("observations of ", decoded, " bytes when decoded, expected: up to ",
                              response_bytes_max_));
  }
  return absl::OkStatus();
}

absl::Status ResponseValidator::ValidateShared(const v1::Batch& batch) const {
  if (!batch.has_shared_batch() || batch.shared_batch() < 0 ||
      batch.shared_batch() >= shared_batch_count_) {
    return Wrong(absl::StrCat(batch.has_shared_batch()
                                  ? absl::StrCat("batch ", batch.shared_batch())
                                  : std::string("no batch"),
                              " of shared memory, expected: 0 to ", shared_batch_count_ - 1));
  }
  if (!batch.last()) {
    return Wrong("one of several responses, expected: one, as the pool shares memory");
  }
  if (batch.shared_observations() != wants_observations_ ||
      batch.shared_final_observations() != wants_final_observations_) {
    return Wrong(absl::StrCat(
        "observations ", batch.shared_observations() ? "" : "not ", "written and final ones ",
        batch.shared_final_observations() ? "" : "not ", "written, expected: as requested"));
  }
  return absl::OkStatus();
}

}  // namespace procgen_client
