#include "server/fleet/log/shard_request.h"

#include "gmock/gmock.h"
#include "google/protobuf/text_format.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

v1::StepPoolRequest Parse(const std::string& text) {
  v1::StepPoolRequest request;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &request)) << text;
  return request;
}

// The request of a shard with `range`; "nothing" if it gets none.
std::string Cut(const std::string& text, Part range) {
  const std::optional<v1::StepPoolRequest> cut = CutRequest(Parse(text), range);
  return cut.has_value() ? cut->DebugString() : "nothing";
}

std::string Text(const std::string& text) { return Parse(text).DebugString(); }

constexpr char kStep[] = R"pb(
  sequence_number: 9
  step {
    slice { first_env: 2 env_count: 6 }
    actions: [ 12, 13, 14, 15, 16, 17 ]
    repeat_count: 3
    observation: OBSERVATION_FRAME
    with_final_observations: true
    chunk_count: 4
    next_levels { environment: 3 level_seed: 33 }
    next_levels { environment: 5 level_seed: 55 }
    resets { environment: 4 level_seed: 44 }
    resets { environment: 7 rand_seed: 77 }
  })pb";

TEST(CutRequestTest, AStepIsCutWithItsActionsLevelsAndResets) {
  EXPECT_EQ(Cut(kStep, {0, 4}), Text(R"pb(step {
                                            slice { first_env: 2 env_count: 2 }
                                            actions: [ 12, 13 ]
                                            repeat_count: 3
                                            observation: OBSERVATION_FRAME
                                            with_final_observations: true
                                            next_levels { environment: 3 level_seed: 33 }
                                          })pb"));
  EXPECT_EQ(Cut(kStep, {4, 2}), Text(R"pb(step {
                                            slice { env_count: 2 }
                                            actions: [ 14, 15 ]
                                            repeat_count: 3
                                            observation: OBSERVATION_FRAME
                                            with_final_observations: true
                                            next_levels { environment: 1 level_seed: 55 }
                                            resets { environment: 0 level_seed: 44 }
                                          })pb"));
  EXPECT_EQ(Cut(kStep, {6, 10}), Text(R"pb(step {
                                             slice { env_count: 2 }
                                             actions: [ 16, 17 ]
                                             repeat_count: 3
                                             observation: OBSERVATION_FRAME
                                             with_final_observations: true
                                             resets { environment: 1 rand_seed: 77 }
                                           })pb"));
}

TEST(CutRequestTest, ShardOutsideTheSliceGetsNoRequest) {
  EXPECT_EQ(Cut(kStep, {0, 2}), "nothing");
  EXPECT_EQ(Cut(kStep, {8, 4}), "nothing");
}

TEST(CutRequestTest, ResetOfOtherShardsBecomesAnObserve) {
  const std::string reset = R"pb(
    reset {
      slice { first_env: 1 env_count: 6 }
      resets { environment: 2 level_seed: 5 rand_seed: 6 }
      observation: OBSERVATION_FRAME
    })pb";
  EXPECT_EQ(Cut(reset, {0, 4}), Text(R"pb(reset {
                                            slice { first_env: 1 env_count: 3 }
                                            resets { environment: 2 level_seed: 5 rand_seed: 6 }
                                            observation: OBSERVATION_FRAME
                                          })pb"));
  EXPECT_EQ(Cut(reset, {4, 4}), Text(R"pb(observe {
                                            slice { env_count: 3 }
                                            observation: OBSERVATION_FRAME
                                          })pb"));
}

TEST(CutRequestTest, AnObserveIsCut) {
  const std::string observe = R"pb(
    observe {
      slice { first_env: 3 env_count: 3 }
      observation: OBSERVATION_NONE
    })pb";
  EXPECT_EQ(Cut(observe, {4, 4}),
            Text("observe { slice { env_count: 2 } observation: OBSERVATION_NONE }"));
}

TEST(CutRequestTest, LevelSamplerGoesToAllShards) {
  const std::string sampler = "level_sampler { level_seeds: [ 1, 2 ] rand_seed: 3 }";
  EXPECT_EQ(Cut("sequence_number: 4 " + sampler, {6, 2}), Text(sampler));
}

TEST(SliceOfTest, EveryRequestKindHasASlice) {
  const auto slice = [](const std::string& text) {
    const Part part = SliceOf(Parse(text), 24);
    return std::pair(part.first, part.count);
  };
  EXPECT_EQ(slice(kStep), std::pair(2, 6));
  EXPECT_EQ(slice("reset { slice { first_env: 3 env_count: 1 } }"), std::pair(3, 1));
  EXPECT_EQ(slice("observe { slice { first_env: 5 env_count: 2 } }"), std::pair(5, 2));
  EXPECT_EQ(slice("level_sampler {}"), std::pair(0, 24));
}

TEST(AskForNoPicturesTest, RemovesObservationsOfEveryRequestKind) {
  v1::StepPoolRequest step = Parse(kStep);
  DisableObservations(&step);
  EXPECT_EQ(step.step().observation(), v1::OBSERVATION_NONE);
  EXPECT_FALSE(step.step().with_final_observations());
  v1::StepPoolRequest reset = Parse("reset { observation: OBSERVATION_FRAME }");
  DisableObservations(&reset);
  EXPECT_EQ(reset.reset().observation(), v1::OBSERVATION_NONE);
  v1::StepPoolRequest observe = Parse("observe { observation: OBSERVATION_FRAME }");
  DisableObservations(&observe);
  EXPECT_EQ(observe.observe().observation(), v1::OBSERVATION_NONE);
}

}  // namespace
}  // namespace procgen
