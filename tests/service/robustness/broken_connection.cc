#include "tests/service/robustness/broken_connection.h"

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "absl/hash/hash.h"
#include "envcore/pool/batch_numbers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 12;
constexpr int32_t kHalf = kEnvCount / 2;
constexpr int kInFlightMax = 3;
// After each of so many responses nothing is in flight, so that the client can take a checkpoint.
constexpr size_t kResponsesPerPause = 20;
// One or two responses.
constexpr int64_t kBytesBetweenFaults = 120'000;
// Several encoded responses: the first of a stream is large, later ones are smaller.
constexpr int64_t kEncodedBytesBetweenFaults = 40'000;

// A fixed sequence: actions kept for several requests, and some that end the episode.
int32_t ActionOf(int request, int32_t environment) {
  const uint32_t mixed = static_cast<uint32_t>(request / 6 * 31 + environment * 17) * 2654435761U;
  return static_cast<int32_t>((mixed >> 16) % 16) - 1;
}

// The arrays of a response for half of the pool.
struct Response {
  BatchNumbers numbers;
  std::vector<uint8_t> observations = std::vector<uint8_t>(size_t{kHalf} * kObservationBytes);
  std::vector<uint8_t> final_observations = std::vector<uint8_t>(observations.size());

  size_t Hash() const {
    return absl::HashOf(observations, final_observations, numbers.rewards, numbers.first,
                        numbers.terminated, numbers.truncated, numbers.level_seeds,
                        numbers.prev_level_seeds, numbers.prev_level_complete,
                        numbers.episode_returns, numbers.episode_lengths, numbers.fingerprints);
  }
};

// Steps the two halves of the pool in turn; each 13th request resets an environment.
Status SendRequest(int request, procgen_client::Pool* pool, Response* response) {
  const int32_t first = request % 2 * kHalf;
  std::vector<int32_t> actions;
  for (int32_t row = 0; row < kHalf; ++row) {
    actions.push_back(ActionOf(request, first + row));
  }
  const Reset reset = {first + 1, std::nullopt, std::nullopt};
  Batch batch;
  batch.observations = absl::MakeSpan(response->observations);
  if (request % 3 == 0) {
    batch.final_observations = absl::MakeSpan(response->final_observations);
  }
  batch = response->numbers.ReplaceEmptyArrays(batch, kHalf);
  return pool->Send(
      {.first = first,
       .count = kHalf,
       .actions = actions,
       .resets = request % 13 == 0 ? absl::MakeConstSpan(&reset, 1) : absl::Span<const Reset>()},
      {}, batch);
}

std::vector<size_t> Play(procgen_client::Pool* pool,
                         const std::function<bool(size_t)>& should_continue) {
  std::vector<size_t> trace;
  std::deque<Response> unanswered;
  int sent = 0;
  while (should_continue(trace.size())) {
    const bool pauses = !unanswered.empty() &&
                        trace.size() % kResponsesPerPause > kResponsesPerPause - kInFlightMax;
    while (!pauses && unanswered.size() < kInFlightMax) {
      EXPECT_THAT(SendRequest(sent++, pool, &unanswered.emplace_back()), IsOk());
    }
    if (const Status status = pool->Receive(std::chrono::seconds(-1)); !status.ok()) {
      ADD_FAILURE() << "after " << trace.size() << " responses: " << status;
      break;
    }
    trace.push_back(unanswered.front().Hash());
    unanswered.pop_front();
  }
  return trace;
}

}  // namespace

FaultProxy::Options FaultyNetwork(const std::string& target, uint32_t seed, v1::Encoding encoding) {
  return {.target = target,
          .seed = seed,
          .bytes_between_faults =
              encoding == v1::ENCODING_RAW ? kBytesBetweenFaults : kEncodedBytesBetweenFaults};
}

std::unique_ptr<procgen_client::RemotePool> CreateRemotePool(
    const std::string& address, const std::vector<std::string>& games, int32_t env_count,
    const procgen_client::RemotePoolOptions& options,
    procgen_client::ConnectOptions connect_options) {
  connect_options.response_bytes_max = 256 << 20;
  absl::StatusOr<std::shared_ptr<procgen_client::Client>> client =
      procgen_client::Client::Connect(address, connect_options);
  EXPECT_THAT(client, IsOk());
  if (!client.ok()) {
    return nullptr;
  }
  PoolOptions pool_options;
  pool_options.games = games;
  pool_options.env_count = env_count;
  pool_options.environment.rand_seed = 5;
  auto pool = procgen_client::RemotePool::Create(*std::move(client), pool_options, options);
  EXPECT_THAT(pool, IsOk());
  return pool.ok() ? *std::move(pool) : nullptr;
}

std::vector<size_t> TraceAt(const std::string& address, v1::Encoding encoding,
                            const std::function<bool(size_t)>& should_continue,
                            const std::function<void()>& on_started) {
  procgen_client::RemotePoolOptions options;
  options.encoding = encoding;
  options.recovery.checkpoint_interval = absl::Milliseconds(20);
  const auto pool = CreateRemotePool(address, {"bigfish", "maze"}, kEnvCount, options);
  on_started();
  return Play(pool.get(), should_continue);
}

void ExpectNothingIsLost(const std::string& address, uint32_t seed, int break_count,
                         v1::Encoding encoding) {
  FaultProxy proxy(FaultyNetwork(address, seed, encoding));
  const std::vector<size_t> trace = TraceAt(
      proxy.address(), encoding,
      [&](size_t /*responses*/) { return proxy.break_count() < break_count; },
      [&] { proxy.SetFaults(true); });
  const std::vector<size_t> expected = TraceAt(
      address, v1::ENCODING_RAW, [&](size_t responses) { return responses < trace.size(); }, [] {});
  EXPECT_GE(proxy.break_count(), break_count);
  EXPECT_GT(trace.size(), static_cast<size_t>(break_count) / 2);
  EXPECT_EQ(trace, expected);
}

}  // namespace procgen
