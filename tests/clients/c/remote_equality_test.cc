// A pool on a server gives, bit for bit, what the same pool in the process gives.

#include <algorithm>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/clients/c/remote_fixture.h"

namespace procgen {
namespace {

constexpr int32_t kSteps = 250;

// Names of the arrays that differ.
std::vector<std::string> DifferencesOf(const BatchBuffers& one, const BatchBuffers& other) {
  std::vector<std::string> names;
  const auto compare = [&](const char* name, const auto& array, const auto& other_array) {
    if (array != other_array) {
      names.emplace_back(name);
    }
  };
  compare("observations", one.observations, other.observations);
  compare("rewards", one.rewards, other.rewards);
  compare("first", one.first, other.first);
  compare("terminated", one.terminated, other.terminated);
  compare("truncated", one.truncated, other.truncated);
  compare("level_seeds", one.level_seeds, other.level_seeds);
  compare("prev_level_seeds", one.prev_level_seeds, other.prev_level_seeds);
  compare("prev_level_complete", one.prev_level_complete, other.prev_level_complete);
  compare("episode_returns", one.episode_returns, other.episode_returns);
  compare("episode_lengths", one.episode_lengths, other.episode_lengths);
  compare("fingerprints", one.fingerprints, other.fingerprints);
  compare("final_observations", one.final_observations, other.final_observations);
  return names;
}

struct Pair {
  CPool local;
  CPool remote;

  // Calls `body` with each pool and its own buffers, which must then be equal.
  template <typename Body>
  void Expect(const ProcgenPoolOptions& options, const Body& body) const {
    ProcgenPoolInfo info = {};
    info.struct_size = sizeof(info);
    ASSERT_EQ(procgen_pool_info(remote.get(), &info), PROCGEN_OK);
    std::vector<BatchBuffers> buffers(
        2, BatchBuffers(options.env_count, static_cast<size_t>(info.observation_bytes)));
    body(local.get(), buffers[0]);
    body(remote.get(), buffers[1]);
    ASSERT_THAT(DifferencesOf(buffers[0], buffers[1]), testing::IsEmpty());
    ASSERT_EQ(buffers[0], buffers[1]);
  }
};

class RemoteEqualityTest : public RemoteTest {
 protected:
  Pair MadePair(const ProcgenPoolOptions& options, int32_t encoding = PROCGEN_RAW) {
    connection_ = Connected();
    return {.local = Made(options), .remote = MadeOn(connection_, options, encoding)};
  }

  CConnection connection_;
};

// Some actions end their episode, so that ends are frequent in every game.
std::vector<int32_t> EndingActionsAt(int32_t step, int32_t env_count) {
  std::vector<int32_t> actions = ActionsAt(step, env_count);
  if (step % 17 == 0) {
    actions[static_cast<size_t>(step / 17 % env_count)] = -1;
  }
  return actions;
}

class RemoteModesTest : public RemoteEqualityTest,
                        public testing::WithParamInterface<std::tuple<int32_t, int32_t>> {};

TEST_P(RemoteModesTest, GamesAndModesEqualThoseInTheProcess) {
  const auto [encoding, autoreset_mode] = GetParam();
  for (const auto& [game, mode] :
       std::vector<std::pair<const char*, int32_t>>{{"coinrun", PROCGEN_EASY},
                                                    {"bigfish", PROCGEN_HARD},
                                                    {"heist", PROCGEN_MEMORY},
                                                    {"starpilot", PROCGEN_EXTREME},
                                                    {"maze", PROCGEN_EXPLORATION}}) {
    COptions options(game, 4);
    options.distribution_mode = mode;
    options.autoreset_mode = autoreset_mode;
    const Pair pair = MadePair(options, encoding);
    std::vector<uint8_t> has_ended(4);
    int ended_count = 0;
    for (int32_t t = 0; t < kSteps; ++t) {
      const std::vector<int32_t> actions = EndingActionsAt(t, 4);
      std::vector<ProcgenReset> resets;
      for (int32_t i = 0; i < 4 && autoreset_mode == PROCGEN_DISABLED; ++i) {
        if (has_ended[static_cast<size_t>(i)] != 0) {
          resets.push_back({i, 0, 0, 0, 0});
        }
      }
      ProcgenStep step = StepOf(actions);
      step.resets = resets.data();
      step.reset_count = static_cast<int32_t>(resets.size());
      pair.Expect(options, [&](ProcgenPool* pool, BatchBuffers& buffers) {
        const ProcgenBatch batch = BatchIn(buffers);
        ASSERT_EQ(procgen_step(pool, &step, &batch), PROCGEN_OK) << procgen_error_message();
        for (size_t i = 0; i < 4; ++i) {
          has_ended[i] = buffers.terminated[i] | buffers.truncated[i];
          ended_count += has_ended[i];
        }
      });
      ASSERT_FALSE(HasFatalFailure()) << game << " step " << t;
    }
    EXPECT_GT(ended_count, 20) << game;
  }
}

INSTANTIATE_TEST_SUITE_P(EncodingsAndModes, RemoteModesTest,
                         testing::Combine(testing::Values(PROCGEN_RAW, PROCGEN_DELTA_ZSTD),
                                          testing::Values(PROCGEN_SAME_STEP, PROCGEN_NEXT_STEP,
                                                          PROCGEN_DISABLED)),
                         [](const auto& info) {
                           return (std::get<0>(info.param) == PROCGEN_RAW ? "Raw" : "DeltaZstd") +
                                  std::string("Autoreset") +
                                  std::to_string(std::get<1>(info.param));
                         });

TEST_F(RemoteEqualityTest, EachOptionReachesTheServer) {
  COptions options("coinrun", 4);
  options.start_level = 3;
  options.num_levels = 2;
  options.use_sequential_levels = 1;
  options.center_agent = 0;
  options.use_backgrounds = 0;
  options.use_monochrome_assets = 1;
  options.restrict_themes = 1;
  options.paint_vel_info = 1;
  options.debug_mode = 1;
  options.screen_size = 32;
  options.grayscale_obs = 1;
  options.layout = PROCGEN_CHW;
  options.frame_stack = 3;
  options.first_env = 1;
  options.total_env_count = 6;
  const Pair pair = MadePair(options, PROCGEN_DELTA_ZSTD);
  for (int32_t t = 0; t < 60; ++t) {
    const std::vector<int32_t> actions = EndingActionsAt(t, 4);
    pair.Expect(options, [&](ProcgenPool* pool, BatchBuffers& buffers) {
      const ProcgenStep step = StepOf(actions);
      const ProcgenBatch batch = BatchIn(buffers);
      ASSERT_EQ(procgen_step(pool, &step, &batch), PROCGEN_OK) << procgen_error_message();
    });
    ASSERT_FALSE(HasFatalFailure()) << "step " << t;
  }
  std::vector<ProcgenPoolInfo> infos(2);
  for (const auto& [pool, info] :
       {std::pair{pair.local.get(), &infos[0]}, std::pair{pair.remote.get(), &infos[1]}}) {
    info->struct_size = sizeof(*info);
    ASSERT_EQ(procgen_pool_info(pool, info), PROCGEN_OK);
  }
  EXPECT_EQ(infos[0].rand_seed, infos[1].rand_seed);
  EXPECT_THAT(infos[1].observation_shape, testing::ElementsAre(3, 1, 32, 32));
  EXPECT_THAT(procgen_pool_name(pair.remote.get()), testing::StartsWith("pools/"));
  EXPECT_STREQ(procgen_pool_name(pair.local.get()), "");
}

TEST_F(RemoteEqualityTest, SlicesInFlightEqualThoseInTheProcess) {
  COptions options("bigfish", 4);
  const Pair pair = MadePair(options);
  pair.Expect(options, [&](ProcgenPool* pool, BatchBuffers& last) {
    std::vector<BatchBuffers> buffers(4, BatchBuffers(2));
    std::vector<std::vector<int32_t>> actions(4);
    for (int32_t t = 0; t < 100; ++t) {
      const auto slot = static_cast<size_t>(t % 4);
      if (t >= 4) {
        ASSERT_EQ(procgen_receive(pool, -1), PROCGEN_OK) << procgen_error_message();
      }
      actions[slot] = EndingActionsAt(t, 2);
      ProcgenStep step = StepOf(actions[slot], t % 2 * 2);
      step.repeat_count = 1 + t % 3;
      const ProcgenBatch batch = BatchIn(buffers[slot]);
      ASSERT_EQ(procgen_send_step(pool, &step, &batch), PROCGEN_OK) << procgen_error_message();
      ASSERT_EQ(procgen_unanswered_count(pool), std::min(t + 1, 4));
    }
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(procgen_receive(pool, -1), PROCGEN_OK);
    }
    ASSERT_EQ(procgen_unanswered_count(pool), 0);
    const ProcgenBatch batch = BatchIn(last);
    ASSERT_EQ(procgen_observe(pool, 0, 4, &batch), PROCGEN_OK);
    ASSERT_EQ(std::vector<uint8_t>(last.observations.begin() + 2 * kObservationBytes,
                                   last.observations.end()),
              buffers[3].observations);
  });
}

TEST_F(RemoteEqualityTest, ResetsNextLevelsAndSamplersEqualThoseInTheProcess) {
  COptions options("maze", 4);
  const std::vector<int32_t> seeds = {100, -5, 102};
  const std::vector<float> weights = {1, 2, 0.5};
  const ProcgenLevelSampler sampler = {.struct_size = sizeof(sampler),
                                       .level_seeds = seeds.data(),
                                       .weights = weights.data(),
                                       .seed_count = 3,
                                       .rand_seed = -1};
  options.level_sampler = &sampler;
  const Pair pair = MadePair(options);
  const std::vector<int32_t> ends(4, -1);
  const auto reset = [&](ProcgenPool* pool, BatchBuffers& buffers) {
    const std::vector<ProcgenReset> resets = {{1, 42, 0, 1, 0}, {2, 0, 9, 0, 1}};
    const ProcgenBatch batch = BatchIn(buffers);
    ASSERT_EQ(procgen_reset(pool, 0, 4, resets.data(), 2, &batch), PROCGEN_OK);
    EXPECT_EQ(buffers.level_seeds[1], 42);
  };
  const auto end = [&](ProcgenPool* pool, BatchBuffers& buffers) {
    const ProcgenNextLevel next = {.environment = 2, .level_seed = 43};
    ProcgenStep step = StepOf(ends);
    step.next_levels = &next;
    step.next_level_count = 1;
    const ProcgenBatch batch = BatchIn(buffers);
    ASSERT_EQ(procgen_step(pool, &step, &batch), PROCGEN_OK);
    EXPECT_EQ(buffers.level_seeds[2], 43);
  };
  const auto sample = [&](ProcgenPool* pool, BatchBuffers& buffers) {
    ProcgenLevelSampler uniform = sampler;
    uniform.weights = nullptr;
    uniform.rand_seed = 5;
    ASSERT_EQ(procgen_set_level_sampler(pool, &uniform), PROCGEN_OK) << procgen_error_message();
    end(pool, buffers);
  };
  for (int i = 0; i < 3; ++i) {
    pair.Expect(options, end);
    pair.Expect(options, reset);
    pair.Expect(options, sample);
  }
}

TEST_F(RemoteEqualityTest, StatesAndFramesEqualThoseInTheProcess) {
  COptions options("coinrun", 4);
  options.frame_stack = 2;
  const Pair pair = MadePair(options, PROCGEN_DELTA_ZSTD);
  const std::vector<int32_t> environments = {3, 1};
  const std::vector<int32_t> targets = {0, 2};
  const auto step = [&](ProcgenPool* pool, BatchBuffers& buffers) {
    const std::vector<int32_t> actions(4, 7);
    const ProcgenStep request = StepOf(actions);
    const ProcgenBatch batch = BatchIn(buffers);
    ASSERT_EQ(procgen_step(pool, &request, &batch), PROCGEN_OK);
  };
  for (int t = 0; t < 20; ++t) {
    pair.Expect(options, step);
  }
  std::vector<std::vector<uint8_t>> states;
  pair.Expect(options, [&](ProcgenPool* pool, BatchBuffers& buffers) {
    std::vector<size_t> offsets(3);
    ASSERT_EQ(procgen_save_states(pool, environments.data(), 2, nullptr, 0, offsets.data()),
              PROCGEN_RESOURCE_EXHAUSTED);
    std::vector<uint8_t>& data = states.emplace_back(offsets[2]);
    ASSERT_EQ(
        procgen_save_states(pool, environments.data(), 2, data.data(), data.size(), offsets.data()),
        PROCGEN_OK);
    step(pool, buffers);
    ASSERT_EQ(procgen_restore_states(pool, targets.data(), 2, data.data(), offsets.data()),
              PROCGEN_OK)
        << procgen_error_message();
    ASSERT_EQ(procgen_clone_states(pool, targets.data(), environments.data(), 2), PROCGEN_OK);
    step(pool, buffers);
  });
  ASSERT_EQ(states.size(), 2U);
  EXPECT_EQ(states[0], states[1]);
  EXPECT_EQ(
      procgen_save_states(pair.remote.get(), nullptr, 0, nullptr, 0, std::vector<size_t>(1).data()),
      PROCGEN_OK);
  for (const auto& [size_px, whole] : {std::pair{16, 0}, {64, 1}, {2048, 0}}) {
    std::vector<std::vector<uint8_t>> frames(
        2, std::vector<uint8_t>(static_cast<size_t>(size_px * size_px * 3)));
    ASSERT_EQ(
        procgen_render(pair.local.get(), 2, size_px, static_cast<uint8_t>(whole), frames[0].data()),
        PROCGEN_OK);
    ASSERT_EQ(procgen_render(pair.remote.get(), 2, size_px, static_cast<uint8_t>(whole),
                             frames[1].data()),
              PROCGEN_OK)
        << procgen_error_message();
    EXPECT_EQ(frames[0], frames[1]) << size_px;
  }
}

TEST_F(RemoteEqualityTest, NullArraysAreNotWritten) {
  for (const int32_t mode : {PROCGEN_SAME_STEP, PROCGEN_NEXT_STEP}) {
    COptions options("maze", 4);
    options.autoreset_mode = mode;
    const Pair pair = MadePair(options);
    const std::vector<int32_t> ends = {4, -1, 4, -1};
    const ProcgenStep step = StepOf(ends);
    pair.Expect(options, [&](ProcgenPool* pool, BatchBuffers& buffers) {
      ProcgenBatch batch = BatchIn(buffers);
      batch.observations = nullptr;
      batch.rewards = nullptr;
      ASSERT_EQ(procgen_step(pool, &step, &batch), PROCGEN_OK);
      EXPECT_THAT(buffers.fingerprints, testing::ElementsAre(0, testing::Ne(0), 0, testing::Ne(0)));
    });
    ProcgenBatch none = {};
    none.struct_size = sizeof(none);
    EXPECT_EQ(procgen_step(pair.remote.get(), &step, &none), PROCGEN_OK);
  }
}

}  // namespace
}  // namespace procgen
