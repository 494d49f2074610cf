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
// Room for five observations, so a response for half of the pool takes two messages.
constexpr int64_t kResponseBytes = 65536;
// One or two responses; more if they have no observations.
constexpr int64_t kBytesBetweenFaults = 120'000;
constexpr int64_t kSharedBytesBetweenFaults = 1'500;
// Several encoded responses: the first of a stream is large, later ones are smaller.
constexpr int64_t kEncodedBytesBetweenFaults = 40'000;
constexpr std::chrono::milliseconds kSilenceMax{15};

// A fixed sequence: actions kept for several requests, and some that end the episode.
int32_t ActionOf(int request, int32_t environment) {
  const uint32_t mixed = static_cast<uint32_t>(request / 6 * 31 + environment * 17) * 2654435761U;
  return static_cast<int32_t>((mixed >> 16) % 16) - 1;
}

// Steps the two halves of the pool in turn; each 13th request resets an environment.
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

// Steps with pipelined requests while `should_continue(response count)`. Returns a hash of each
// response.
std::vector<size_t> Play(procgen_client::StepStream* stream,
                         const std::function<bool(size_t)>& should_continue) {
  std::vector<size_t> trace;
  procgen_client::Batch batch;
  int sent = 0;
  while (should_continue(trace.size())) {
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

FaultProxy::Options FaultyNetwork(const std::string& target, uint32_t seed,
                                  const TransportCase& transport_case) {
  FaultProxy::Options options = {
      .target = target, .seed = seed, .bytes_between_faults = kBytesBetweenFaults};
  if (transport_case.transport == v1::TRANSPORT_SHARED_MEMORY) {
    options.bytes_between_faults = kSharedBytesBetweenFaults;
    // The pipe transport bypasses the proxy.
    options.silence_max =
        transport_case.pipe_transport ? kSilenceMax : std::chrono::milliseconds::zero();
  } else if (transport_case.encoding != v1::ENCODING_RAW) {
    options.bytes_between_faults = kEncodedBytesBetweenFaults;
  }
  return options;
}

v1::PoolSpec TracedSpec(const TransportCase& transport_case) {
  v1::PoolSpec spec;
  spec.set_transport(transport_case.transport);
  spec.set_encoding(transport_case.encoding);
  spec.add_games("bigfish");
  spec.add_games("maze");
  spec.set_env_count(kEnvCount);
  spec.mutable_options()->set_rand_seed(5);
  spec.mutable_lease_duration()->set_seconds(3600);
  return spec;
}

std::vector<size_t> TraceAt(const std::string& address, const std::string& pool,
                            const TransportCase& transport_case,
                            const std::function<bool(size_t)>& should_continue,
                            const std::function<void()>& on_attached) {
  const auto client = procgen_client::Client::Connect(address);
  EXPECT_THAT(client, IsOk());
  const auto stream = (*client)->Attach(pool, {.requests_in_flight_max = 3,
                                               .response_bytes_max = kResponseBytes,
                                               .pipe_transport = transport_case.pipe_transport});
  EXPECT_THAT(stream, IsOk());
  on_attached();
  return Play(stream->get(), should_continue);
}

void ExpectNothingIsLost(const std::string& address, uint32_t seed, int break_count,
                         const TransportCase& transport_case) {
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  const auto pool = (*client)->CreatePool(TracedSpec(transport_case));
  const auto other_pool = (*client)->CreatePool(TracedSpec());
  ASSERT_THAT(pool, IsOk());
  ASSERT_THAT(other_pool, IsOk());

  FaultProxy proxy(FaultyNetwork(address, seed, transport_case));
  const std::vector<size_t> trace = TraceAt(
      proxy.address(), pool->name(), transport_case,
      [&](size_t /*answers*/) { return proxy.break_count() < break_count; },
      [&] { proxy.SetFaults(true); });
  const std::vector<size_t> expected = TraceAt(
      address, other_pool->name(), {}, [&](size_t answers) { return answers < trace.size(); },
      [] {});
  EXPECT_GE(proxy.break_count(), break_count);
  EXPECT_GT(trace.size(), static_cast<size_t>(break_count) / 2);
  EXPECT_EQ(trace, expected);
  EXPECT_THAT((*client)->DeletePool(pool->name()), IsOk());
  EXPECT_THAT((*client)->DeletePool(other_pool->name()), IsOk());
}

}  // namespace procgen
