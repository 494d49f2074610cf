// A learner over the stream receives what one in the process receives, bit for bit.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 12;
constexpr int kSteps = 300;

// The arrays of a batch, with their memory.
struct Values : BatchNumbers {
  std::vector<uint8_t> observations = std::vector<uint8_t>(size_t{kEnvCount} * kObservationBytes);

  Batch Spans() {
    Batch batch;
    batch.observations = absl::MakeSpan(observations);
    return ReplaceEmptyArrays(batch, kEnvCount);
  }

  // The fingerprints that a response contains: of rows whose episode ended.
  std::vector<uint64_t> EndedFingerprints() const {
    std::vector<uint64_t> ended;
    for (size_t row = 0; row < fingerprints.size(); ++row) {
      if (terminated[row] != 0 || truncated[row] != 0) {
        ended.push_back(fingerprints[row]);
      }
    }
    return ended;
  }
};

template <typename Left, typename Right>
bool Same(const Left& left, const Right& right) {
  return std::equal(
      left.begin(), left.end(), right.begin(), right.end(),
      [](auto mine, auto other) { return mine == static_cast<decltype(mine)>(other); });
}

bool Same(const Values& local, const v1::Batch& remote) {
  return Same(local.observations, remote.observations()) && Same(local.rewards, remote.rewards()) &&
         Same(local.first, remote.first()) && Same(local.terminated, remote.terminated()) &&
         Same(local.truncated, remote.truncated()) &&
         Same(local.level_seeds, remote.level_seeds()) &&
         Same(local.prev_level_seeds, remote.prev_level_seeds()) &&
         Same(local.prev_level_complete, remote.prev_level_complete()) &&
         Same(local.episode_returns, remote.episode_returns()) &&
         Same(local.episode_lengths, remote.episode_lengths()) &&
         Same(local.EndedFingerprints(), remote.fingerprints());
}

// A fixed sequence: actions kept for five steps, and some that end the episode.
std::vector<int32_t> ActionsAt(int step) {
  std::vector<int32_t> actions(kEnvCount);
  for (int32_t i = 0; i < kEnvCount; ++i) {
    const uint32_t mixed = static_cast<uint32_t>(step / 5 * 31 + i * 17) * 2654435761U;
    actions[static_cast<size_t>(i)] = static_cast<int32_t>((mixed >> 16) % 16) - 1;
  }
  return actions;
}

class TraceTest : public ServiceTest,
                  public testing::WithParamInterface<std::vector<std::string>> {};

TEST_P(TraceTest, StreamEqualsInProcess) {
  PoolOptions options;
  options.games = GetParam();
  options.env_count = kEnvCount;
  options.environment.rand_seed = 11;
  const absl::StatusOr<std::unique_ptr<Pool>> pool =
      Pool::Create(options, std::make_shared<WorkerPool>(0));
  ASSERT_THAT(pool, IsOk());
  v1::PoolSpec spec;
  spec.mutable_games()->Assign(options.games.begin(), options.games.end());
  spec.set_env_count(kEnvCount);
  spec.mutable_options()->set_rand_seed(11);
  const auto stream = StartPool(spec);
  ASSERT_NE(stream, nullptr);

  Values local;
  v1::Batch remote;
  ASSERT_THAT((*pool)->Observe(0, kEnvCount, local.Spans()), IsOk());
  ASSERT_THAT(stream->Observe(&remote), IsOk());
  ASSERT_TRUE(Same(local, remote)) << "before the first step";
  for (int step = 0; step < kSteps; ++step) {
    const std::vector<int32_t> actions = ActionsAt(step);
    StepInput input;
    input.count = kEnvCount;
    input.actions = actions;
    ASSERT_THAT((*pool)->Step(input, local.Spans()), IsOk());
    ASSERT_THAT(stream->Step(actions, &remote), IsOk());
    ASSERT_TRUE(Same(local, remote)) << "in step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(Games, TraceTest,
                         testing::Values(std::vector<std::string>{"bigfish"},
                                         std::vector<std::string>{"coinrun"},
                                         std::vector<std::string>{"maze"},
                                         std::vector<std::string>{"miner"},
                                         std::vector<std::string>{"maze", "coinrun", "bigfish"}));

}  // namespace
}  // namespace procgen
