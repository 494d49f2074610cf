#include "tests/service/robustness/broken_connection.h"

#include <chrono>
#include <functional>
#include <memory>
#include <vector>

#include "absl/hash/hash.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 12;
constexpr int32_t kHalf = kEnvCount / 2;
// Room for five observations: the answer for a half comes in two responses.
constexpr int64_t kResponseBytes = 65536;
// The answers to one or two requests, and to some more where they bear no observations.
constexpr int64_t kBytesBetweenFaults = 120'000;
constexpr int64_t kSharedBytesBetweenFaults = 1'500;
// Those to some that are encoded: the first of a stream, and then smaller ones.
constexpr int64_t kEncodedBytesBetweenFaults = 40'000;
constexpr std::chrono::milliseconds kSilenceMax{15};

// Any fixed sequence will do: sticky moves with an end of the episode now and then.
int32_t ActionOf(int request, int32_t environment) {
  const uint32_t mixed = static_cast<uint32_t>(request / 6 * 31 + environment * 17) * 2654435761U;
  return static_cast<int32_t>((mixed >> 16) % 16) - 1;
}

// Steps one half of the pool and then the other; each 13th request resets an environment.
v1::StepPoolRequest RequestAt(int request) {
  const int32_t first = request % 2 * kHalf;
  v1::StepPoolRequest message = SliceStepRequest(first, kHalf, 4);
  for (int32_t row = 0; row < kHalf; ++row) {
    message.mutable_step()->set_actions(row, ActionOf(request, first + row));
  }
  message.mutable_step()->set_with_final_observations(request % 3 == 0);
  message.mutable_step()->set_chunk_count(request % 4);
  if (request % 13 == 0) {
    message.mutable_step()->add_resets()->set_environment(first + 1);
  }
  return message;
}

size_t HashOf(const procgen_client::Batch& batch) {
  return absl::HashOf(batch.sequence_number(), batch.first_env(), batch.observations(),
                      batch.final_observations(), batch.rewards(), batch.first(),
                      batch.terminated(), batch.truncated(), batch.level_seeds(),
                      batch.prev_level_seeds(), batch.prev_level_complete(),
                      batch.episode_returns(), batch.episode_lengths(), batch.fingerprints());
}

// Steps with requests sent ahead while `goes_on(number of answers)`; hashes of all answers.
std::vector<size_t> Play(procgen_client::StepStream* stream,
                         const std::function<bool(size_t)>& goes_on) {
  std::vector<size_t> trace;
  procgen_client::Batch batch;
  int sent = 0;
  while (goes_on(trace.size())) {
    while (sent < static_cast<int>(trace.size()) + stream->requests_in_flight_max()) {
      EXPECT_THAT(stream->Send(RequestAt(sent++)), IsOk());
    }
    if (absl::Status status = stream->Receive(&batch); !status.ok()) {
      ADD_FAILURE() << "after " << trace.size() << " answers: " << status;
      break;
    }
    trace.push_back(HashOf(batch));
  }
  return trace;
}

}  // namespace

FaultProxy::Options BadNetwork(const std::string& target, uint32_t seed,
                               const TransportCase& carriage) {
  FaultProxy::Options options = {
      .target = target, .seed = seed, .bytes_between_faults = kBytesBetweenFaults};
  if (carriage.transport == v1::TRANSPORT_SHARED_MEMORY) {
    options.bytes_between_faults = kSharedBytesBetweenFaults;
    // What goes past gRPC goes past the network, too.
    options.silence_max = carriage.pipe_transport ? kSilenceMax : std::chrono::milliseconds::zero();
  } else if (carriage.encoding != v1::ENCODING_RAW) {
    options.bytes_between_faults = kEncodedBytesBetweenFaults;
  }
  return options;
}

v1::PoolSpec TracedSpec(const TransportCase& carriage) {
  v1::PoolSpec spec;
  spec.set_transport(carriage.transport);
  spec.set_encoding(carriage.encoding);
  spec.add_games("bigfish");
  spec.add_games("maze");
  spec.set_env_count(kEnvCount);
  spec.mutable_options()->set_rand_seed(5);
  spec.mutable_lease_duration()->set_seconds(3600);
  return spec;
}

std::vector<size_t> TraceAt(const std::string& address, const std::string& pool,
                            const TransportCase& carriage,
                            const std::function<bool(size_t)>& goes_on,
                            const std::function<void()>& when_attached) {
  const auto client = procgen_client::Client::Connect(address);
  EXPECT_THAT(client, IsOk());
  const auto stream = (*client)->Attach(pool, {.requests_in_flight_max = 3,
                                               .response_bytes_max = kResponseBytes,
                                               .pipe_transport = carriage.pipe_transport});
  EXPECT_THAT(stream, IsOk());
  when_attached();
  return Play(stream->get(), goes_on);
}

void ExpectNothingIsLost(const std::string& address, uint32_t seed, int break_count,
                         const TransportCase& carriage) {
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  const auto pool = (*client)->CreatePool(TracedSpec(carriage));
  const auto other_pool = (*client)->CreatePool(TracedSpec());
  ASSERT_THAT(pool, IsOk());
  ASSERT_THAT(other_pool, IsOk());

  FaultProxy proxy(BadNetwork(address, seed, carriage));
  const std::vector<size_t> trace = TraceAt(
      proxy.address(), pool->name(), carriage,
      [&](size_t /*answers*/) { return proxy.break_count() < break_count; },
      [&] { proxy.SetFaults(true); });
  const std::vector<size_t> undisturbed = TraceAt(
      address, other_pool->name(), {}, [&](size_t answers) { return answers < trace.size(); },
      [] {});
  EXPECT_GE(proxy.break_count(), break_count);
  EXPECT_GT(trace.size(), static_cast<size_t>(break_count) / 2);
  EXPECT_EQ(trace, undisturbed);
  EXPECT_THAT((*client)->DeletePool(pool->name()), IsOk());
  EXPECT_THAT((*client)->DeletePool(other_pool->name()), IsOk());
}

}  // namespace procgen
