#include "procgen_client/internal/response_validator.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

constexpr int32_t kEnvCount = 6;
constexpr int32_t kObservationBytes = 64 * 64 * 3;

v1::Attach AttachOf(const std::string& pool) {
  v1::Attach attach;
  attach.set_pool(pool);
  return attach;
}

v1::Attached AttachedTo(const std::string& pool) {
  v1::Attached attached;
  attached.mutable_pool()->set_name(pool);
  attached.mutable_pool()->mutable_spec()->set_env_count(kEnvCount);
  for (const int32_t size : {64, 64, 3}) {
    attached.mutable_pool()->add_observation_shape(size);
  }
  attached.mutable_pool()->set_observation_bytes(kObservationBytes);
  attached.set_next_sequence_number(1);
  attached.set_oldest_kept_sequence_number(1);
  attached.set_response_bytes_max(4 << 20);
  attached.set_requests_in_flight_max(2);
  return attached;
}

v1::StepPoolRequest Request(int32_t first, int32_t count) {
  v1::StepPoolRequest request;
  request.set_sequence_number(7);
  v1::Step* step = request.mutable_step();
  step->mutable_slice()->set_first_env(first);
  step->mutable_slice()->set_env_count(count);
  step->mutable_actions()->Resize(count, 4);
  step->set_with_final_observations(true);
  return request;
}

// A valid response to a part of Request(), in which the first environment's episode ended.
v1::StepPoolResponse Response(int32_t first, int32_t count, bool last) {
  v1::StepPoolResponse response;
  response.set_sequence_number(7);
  v1::Batch* batch = response.mutable_batch();
  batch->set_first_env(first);
  batch->set_env_count(count);
  batch->set_last(last);
  batch->mutable_rewards()->Resize(count, 0);
  batch->mutable_first()->Resize(count, false);
  batch->mutable_terminated()->Resize(count, false);
  batch->set_terminated(0, true);
  batch->mutable_truncated()->Resize(count, false);
  batch->mutable_level_seeds()->Resize(count, 1);
  batch->mutable_prev_level_seeds()->Resize(count, 1);
  batch->mutable_prev_level_complete()->Resize(count, false);
  batch->mutable_episode_returns()->Resize(count, 0);
  batch->mutable_episode_lengths()->Resize(count, 1);
  batch->add_fingerprints(99);
  batch->set_final_observations(std::string(kObservationBytes, 'f'));
  batch->set_observations(std::string(static_cast<size_t>(count) * kObservationBytes, 'o'));
  return response;
}

using Change = std::function<void(v1::StepPoolResponse*)>;

absl::Status StatusFor(const v1::Attached& attached, const v1::StepPoolRequest& request,
                       const v1::StepPoolResponse& response, int32_t shared_batch_count = 0) {
  procgen_client::ResponseValidator validator(attached, shared_batch_count);
  validator.Expect(request);
  return validator.Validate(response);
}

TEST(ResponseValidatorTest, MatchingResponseIsValid) {
  EXPECT_THAT(StatusFor(AttachedTo("pools/a"), Request(0, 6), Response(0, 6, true)), IsOk());
  EXPECT_THAT(StatusFor(AttachedTo("pools/a"), Request(2, 3), Response(2, 3, true)), IsOk());
}

TEST(ResponseValidatorTest, ChunkedResponseIsCompleteWithItsLastChunk) {
  procgen_client::ResponseValidator validator(AttachedTo("pools/a"), 0);
  validator.Expect(Request(1, 5));
  EXPECT_THAT(validator.Validate(Response(1, 2, false)), IsOk());
  EXPECT_FALSE(validator.is_complete());
  EXPECT_THAT(validator.Validate(Response(3, 3, true)), IsOk());
  EXPECT_TRUE(validator.is_complete());
}

TEST(ResponseValidatorTest, MismatchedResponseIsDataLoss) {
  const std::pair<Change, std::string> cases[] = {
      {[](auto* r) { r->set_sequence_number(8); }, "request 7: number 8, expected: 7"},
      {[](auto* r) { r->clear_batch(); }, "a response of kind 0, expected: 4"},
      {[](auto* r) { r->mutable_ack(); }, "a response of kind 3, expected: 4"},
      {[](auto* r) { r->mutable_attached(); }, "a response of kind 2, expected: 4"},
      {[](auto* r) { r->mutable_batch()->set_first_env(1 << 30); },
       "6 environments from 1073741824, expected: 1 to 6 from 0"},
      {[](auto* r) { r->mutable_batch()->set_first_env(-1); }, "from -1, expected"},
      {[](auto* r) { r->mutable_batch()->set_env_count(0); }, "0 environments from 0"},
      {[](auto* r) { r->mutable_batch()->set_env_count(-6); }, "-6 environments from 0"},
      {[](auto* r) { r->mutable_batch()->set_env_count(INT32_MAX); },
       "2147483647 environments from 0, expected: 1 to 6"},
      {[](auto* r) { r->mutable_batch()->set_last(false); }, "0 to 5 as not the last, expected"},
      {[](auto* r) { *r = Response(0, 5, true); }, "0 to 4 as the last, expected: up to 5"},
      {[](auto* r) { r->mutable_batch()->mutable_rewards()->Truncate(1); },
       "rewards of size 1, expected: 6"},
      {[](auto* r) { r->mutable_batch()->clear_first(); }, "first of size 0, expected: 6"},
      {[](auto* r) { r->mutable_batch()->add_terminated(false); },
       "terminated of size 7, expected: 6"},
      {[](auto* r) { r->mutable_batch()->clear_truncated(); }, "truncated of size 0"},
      {[](auto* r) { r->mutable_batch()->clear_level_seeds(); }, "level_seeds of size 0"},
      {[](auto* r) { r->mutable_batch()->clear_prev_level_seeds(); }, "prev_level_seeds of size 0"},
      {[](auto* r) { r->mutable_batch()->clear_prev_level_complete(); }, "prev_level_complete of"},
      {[](auto* r) { r->mutable_batch()->clear_episode_returns(); }, "episode_returns of size 0"},
      {[](auto* r) { r->mutable_batch()->clear_episode_lengths(); }, "episode_lengths of size 0"},
      {[](auto* r) { r->mutable_batch()->set_truncated(3, true); },
       "fingerprints of size 1, expected: 2"},
      {[](auto* r) { r->mutable_batch()->add_fingerprints(1); }, "fingerprints of size 2"},
      {[](auto* r) { r->mutable_batch()->clear_final_observations(); },
       "final_observations of size 0, expected: 12288"},
      {[](auto* r) { r->mutable_batch()->set_observations("ten bytes."); },
       "observations of size 10, expected: 73728"},
      {[](auto* r) { r->mutable_batch()->clear_observations(); }, "observations of size 0"},
      {[](auto* r) { r->mutable_batch()->set_shared_batch(0); }, "the pool shares no memory"},
  };
  for (const auto& [change, message] : cases) {
    v1::StepPoolResponse response = Response(0, 6, true);
    change(&response);
    EXPECT_THAT(StatusFor(AttachedTo("pools/a"), Request(0, 6), response),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)));
  }
}

TEST(ResponseValidatorTest, EnvironmentsComeInOrderAndOnce) {
  for (const int32_t first : {0, 1, 3}) {
    procgen_client::ResponseValidator validator(AttachedTo("pools/a"), 0);
    validator.Expect(Request(0, 6));
    ASSERT_THAT(validator.Validate(Response(0, 2, false)), IsOk());
    EXPECT_THAT(validator.Validate(Response(first, 3, false)),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr("expected: 1 to 4 from 2")));
  }
}

TEST(ResponseValidatorTest, UnrequestedFieldsAreRejected) {
  v1::StepPoolRequest request = Request(0, 6);
  request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  EXPECT_THAT(StatusFor(AttachedTo("pools/a"), request, Response(0, 6, true)),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("size 73728, expected: 0")));
  request = Request(0, 6);
  request.mutable_step()->clear_with_final_observations();
  EXPECT_THAT(StatusFor(AttachedTo("pools/a"), request, Response(0, 6, true)),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("size 12288, expected: 0")));
  request.mutable_level_sampler();
  EXPECT_THAT(StatusFor(AttachedTo("pools/a"), request, Response(0, 6, true)),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("kind 4, expected: 3")));
}

TEST(ResponseValidatorTest, ServerWithoutFingerprintsSendsNone) {
  v1::StepPoolResponse response = Response(0, 6, true);
  response.mutable_batch()->clear_fingerprints();
  EXPECT_THAT(StatusFor(AttachedTo("pools/a"), Request(0, 6), response), IsOk());
}

TEST(ResponseValidatorTest, DecodedObservationsAreBoundedByTheResponseLimit) {
  v1::Attached attached = AttachedTo("pools/a");
  attached.mutable_pool()->mutable_spec()->set_encoding(v1::ENCODING_DELTA_ZSTD);
  v1::StepPoolResponse response = Response(0, 6, true);
  response.mutable_batch()->set_observations("frame");
  EXPECT_THAT(StatusFor(attached, Request(0, 6), response), IsOk());
  attached.set_response_bytes_max(65536);
  EXPECT_THAT(StatusFor(attached, Request(0, 6), response),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("73728 bytes when decoded, expected: up to")));
}

TEST(ResponseValidatorTest, SharedBatchNumbersMustExist) {
  v1::StepPoolResponse right;
  right.set_sequence_number(7);
  right.mutable_batch()->set_env_count(6);
  right.mutable_batch()->set_last(true);
  right.mutable_batch()->set_shared_batch(2);
  right.mutable_batch()->set_shared_observations(true);
  right.mutable_batch()->set_shared_final_observations(true);
  EXPECT_THAT(StatusFor(AttachedTo("pools/a"), Request(0, 6), right, 3), IsOk());
  const std::pair<Change, std::string> cases[] = {
      {[](auto* r) { r->mutable_batch()->set_shared_batch(3); }, "batch 3 of shared memory"},
      {[](auto* r) { r->mutable_batch()->set_shared_batch(-1); }, "batch -1 of shared memory"},
      {[](auto* r) { r->mutable_batch()->clear_shared_batch(); }, "no batch of shared memory"},
      {[](auto* r) { r->mutable_batch()->set_env_count(7); }, "expected: 1 to 6 from 0"},
      {[](auto* r) { r->mutable_batch()->set_shared_observations(false); }, "not written"},
  };
  for (const auto& [change, message] : cases) {
    v1::StepPoolResponse response = right;
    change(&response);
    EXPECT_THAT(StatusFor(AttachedTo("pools/a"), Request(0, 6), response, 3),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)));
  }
}

TEST(ResponseValidatorTest, AttachResponseIsValidated) {
  const v1::Attach attach = AttachOf("pools/a");
  EXPECT_THAT(procgen_client::ValidateAttached(attach, AttachedTo("pools/a")), IsOk());
  const std::pair<std::function<void(v1::Attached*)>, std::string> cases[] = {
      {[](auto* a) { a->mutable_pool()->set_name("pools/b"); },
       "pool 'pools/b', expected: 'pools/a'"},
      {[](auto* a) { a->clear_pool(); }, "pool '', expected"},
      {[](auto* a) { a->mutable_pool()->mutable_spec()->set_env_count(0); }, "pool of 0 environ"},
      {[](auto* a) { a->mutable_pool()->mutable_spec()->set_env_count(-5); }, "pool of -5 environ"},
      {[](auto* a) { a->mutable_pool()->mutable_spec()->set_env_count(INT32_MAX); },
       "2147483647 environments, expected: 1 to 16777216"},
      {[](auto* a) { a->mutable_pool()->set_observation_bytes(1); }, "observations of 1 bytes"},
      {[](auto* a) { a->mutable_pool()->set_observation_shape(0, INT32_MAX); }, "of 12288 bytes"},
      {[](auto* a) { a->mutable_pool()->set_observation_shape(0, -64); }, "of 12288 bytes"},
      {[](auto* a) { a->mutable_pool()->clear_observation_shape(); }, "of 12288 bytes"},
      {[](auto* a) { a->set_requests_in_flight_max(0); }, "0 requests in flight"},
      {[](auto* a) { a->set_response_bytes_max(0); }, "responses of 0 bytes"},
      {[](auto* a) { a->set_response_bytes_max(INT64_MAX); }, "expected: 1 to 4194304"},
      {[](auto* a) { a->set_next_sequence_number(0); }, "next request 0"},
      {[](auto* a) { a->set_oldest_kept_sequence_number(2); }, "oldest kept 2"},
      {[](auto* a) { a->mutable_shared_memory(); }, "shared memory, expected: none"},
      {[](auto* a) {
         a->mutable_pool()->mutable_spec()->set_transport(v1::TRANSPORT_SHARED_MEMORY);
       },
       "no shared memory, expected"},
  };
  for (const auto& [change, message] : cases) {
    v1::Attached attached = AttachedTo("pools/a");
    change(&attached);
    EXPECT_THAT(procgen_client::ValidateAttached(attach, attached),
                StatusIs(absl::StatusCode::kInternal, HasSubstr(message)));
  }
}

}  // namespace
}  // namespace procgen
