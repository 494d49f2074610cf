#include "server/wire/convert_step.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kObservation = 64 * 64 * 3;  // bytes

TEST(ConvertStepTest, StepIsConverted) {
  v1::RunPoolRequest message;
  v1::Step* step = message.mutable_step();
  step->mutable_slice()->set_first_env(3);
  step->mutable_slice()->set_env_count(2);
  step->add_actions(-1);
  step->add_actions(14);
  v1::NextLevel* next_level = step->add_next_levels();
  next_level->set_environment(4);
  next_level->set_level_seed(-5);
  v1::Reset* reset = step->add_resets();
  reset->set_environment(3);
  reset->set_level_seed(0);
  v1::Annotation* annotation = step->add_annotations();
  annotation->set_name("value");
  annotation->add_values(1.5F);
  step->set_with_final_observations(true);
  step->set_acknowledge_only(true);
  RequestMemory memory;
  ASSERT_THAT(ReadRequest(message, &memory), IsOk());
  const Request& request = memory.request;
  EXPECT_EQ(request.kind, Request::Kind::kStep);
  EXPECT_EQ(request.first, 3);
  EXPECT_EQ(request.count, 2);
  EXPECT_THAT(request.actions, ElementsAre(-1, 14));
  EXPECT_EQ(request.repeat, 1) << "0 is the default";
  ASSERT_EQ(request.next_levels.size(), 1U);
  EXPECT_EQ(request.next_levels[0].environment, 4);
  EXPECT_EQ(request.next_levels[0].level_seed, -5);
  ASSERT_EQ(request.resets.size(), 1U);
  EXPECT_EQ(request.resets[0].environment, 3);
  EXPECT_EQ(request.resets[0].level_seed, 0) << "0 differs from unset";
  EXPECT_FALSE(request.resets[0].rand_seed.has_value());
  ASSERT_EQ(request.annotations.size(), 1U);
  EXPECT_EQ(request.annotations[0].name, "value");
  EXPECT_THAT(request.annotations[0].values, ElementsAre(1.5F));
  EXPECT_TRUE(request.with_observations);
  EXPECT_TRUE(request.with_final_observations);
  EXPECT_TRUE(request.acknowledge_only);
}

TEST(ConvertStepTest, NothingOfTheLastRequestIsKept) {
  v1::RunPoolRequest message;
  message.mutable_step()->add_resets();
  message.mutable_step()->add_next_levels();
  message.mutable_step()->add_annotations();
  message.mutable_step()->set_acknowledge_only(true);
  RequestMemory memory;
  ASSERT_THAT(ReadRequest(message, &memory), IsOk());
  v1::RunPoolRequest observe;
  observe.mutable_observe();
  ASSERT_THAT(ReadRequest(observe, &memory), IsOk());
  EXPECT_EQ(memory.request.kind, Request::Kind::kObserve);
  EXPECT_TRUE(memory.request.resets.empty());
  EXPECT_TRUE(memory.request.next_levels.empty());
  EXPECT_TRUE(memory.request.annotations.empty());
  EXPECT_FALSE(memory.request.acknowledge_only);
  ASSERT_THAT(ReadRequest(message, &memory), IsOk());
  EXPECT_EQ(memory.request.resets.size(), 1U);
}

TEST(ConvertStepTest, EmptyRequestIsRejected) {
  RequestMemory memory;
  EXPECT_THAT(ReadRequest({}, &memory),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("is empty, allowed")));
}

TEST(ConvertStepTest, UnknownObservationIsRejected) {
  v1::RunPoolRequest message;
  message.mutable_observe()->set_observation(static_cast<v1::Observation>(9));
  RequestMemory memory;
  EXPECT_THAT(ReadRequest(message, &memory),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("observation is number 9")));
}

TEST(ConvertStepTest, ResponseBeyondItsLimitIsRejected) {
  Request request;
  request.kind = Request::Kind::kStep;
  request.count = 340;
  const int64_t limit = 4 << 20;
  EXPECT_THAT(CheckResponseFits(request, Encoding::kRaw, kObservation, limit), IsOk());
  request.count = 341;
  EXPECT_THAT(CheckResponseFits(request, Encoding::kRaw, kObservation, limit),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "slice.env_count is 341, limit response_bytes_max is 4194304, which has "
                       "room for 340 environments of 12288 bytes"));
  request.acknowledge_only = true;
  EXPECT_THAT(CheckResponseFits(request, Encoding::kRaw, kObservation, limit), IsOk());
  request.acknowledge_only = false;
  request.with_observations = false;
  EXPECT_THAT(CheckResponseFits(request, Encoding::kRaw, kObservation, limit), IsOk());
  request.with_final_observations = true;
  EXPECT_FALSE(CheckResponseFits(request, Encoding::kRaw, kObservation, limit).ok());
}

}  // namespace
}  // namespace procgen
