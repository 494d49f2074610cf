// Looking at a pool from beside its stream.

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class RenderTest : public ServiceTest {};

TEST_F(RenderTest, FramesComeInTheOrderAskedFor) {
  const std::string name = CreatePool(MazeSpec(4));
  const auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*stream)->Step({4, 4, 4, 4}, &batch), IsOk());
  const auto frames = client_->RenderEnvironments(name, {3, 0, 3}, 128);
  ASSERT_THAT(frames, IsOk());
  ASSERT_EQ(frames->frames_size(), 3);
  EXPECT_EQ(frames->sequence_number(), 1);
  EXPECT_EQ(frames->frames(0).environment(), 3);
  EXPECT_EQ(frames->frames(1).environment(), 0);
  EXPECT_EQ(frames->frames(0).width_px(), 128);
  EXPECT_EQ(frames->frames(0).image().size(), 128U * 128 * 3);
  EXPECT_EQ(frames->frames(0).image(), frames->frames(2).image());
  ASSERT_THAT((*stream)->Step({4, 4, 4, 4}, &batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), testing::Each(2));
}

TEST_F(RenderTest, WrongInputsAreRefused) {
  const std::string name = CreatePool(MazeSpec(2));
  EXPECT_THAT(client_->RenderEnvironments(name, {2}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "environments[0] is 2, pool " + name + " has environments 0 to 1"));
  EXPECT_THAT(client_->RenderEnvironments(name, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("environments is empty")));
  EXPECT_THAT(client_->RenderEnvironments(name, {0}, 15),
              StatusIs(absl::StatusCode::kInvalidArgument, "side_px is 15, allowed: 16 to 2048"));
  EXPECT_THAT(client_->RenderEnvironments("pools/nothing", {0}),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("pools/nothing")));
}

}  // namespace
}  // namespace procgen
