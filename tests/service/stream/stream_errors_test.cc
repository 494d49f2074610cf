// Errors that a request on a stream can cause: code and message. The fixture checks the server
// and another pool.

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class StreamErrorsTest : public ServiceTest {
 protected:
  // Sends an invalid request between valid ones. Expects that those before are answered, and that
  // the error ends the stream.
  void ExpectInvalid(const v1::RunPoolRequest& request,
                     const testing::Matcher<std::string>& message) {
    const auto stream = StartPool(MazeSpec(4), "mine");
    stream->Write(StepRequest({4, 4, 4, 4}));
    stream->Write(request);
    stream->Write(StepRequest({4, 4, 4, 4}));
    v1::Batch batch;
    EXPECT_THAT(stream->Read(&batch), IsOk());
    EXPECT_THAT(batch.episode_lengths(), testing::Each(1));
    EXPECT_THAT(stream->Read(), StatusIs(absl::StatusCode::kInvalidArgument, message));
    EXPECT_FALSE(stream->drained());
  }
};

// tests/server/pool/request_test.cc has the other ranges.
TEST_F(StreamErrorsTest, ValuesOutOfRange) {
  ExpectInvalid(StepRequest({4, 15, 4, 4}), "actions[1] is 15, allowed: -1 to 14");
  ExpectInvalid(ObserveRequest(-1),
                "slice.env_count is -1, allowed from environment 0 of pool pools/mine on: 1 to 4");
  v1::RunPoolRequest request = StepRequest({4, 4, 4, 4});
  request.mutable_step()->clear_slice();
  ExpectInvalid(request,
                "slice.env_count is 0, allowed from environment 0 of pool pools/mine on: 1 to 4");
  request.mutable_level_sampler();
  ExpectInvalid(request, "level_sampler.level_seeds has 0 entries, must have 1 to 1000000");
}

TEST_F(StreamErrorsTest, RequestsOfOtherKinds) {
  ExpectInvalid(v1::RunPoolRequest(), HasSubstr("the request is empty"));
  ExpectInvalid(StartRequest(MazeSpec(1)),
                "start was sent again, allowed: once, as the first request");
}

TEST_F(StreamErrorsTest, EndedEpisodeIsNotSteppedWithoutAutoreset) {
  v1::PoolSpec spec = MazeSpec(2);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const auto stream = StartPool(spec);
  v1::Batch batch;
  ASSERT_THAT(stream->Step({4, -1}, &batch), IsOk());
  EXPECT_THAT(batch.terminated(), testing::ElementsAre(false, true));
  EXPECT_THAT(stream->Step({4, 4}, &batch),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("the episode of environment 1 of pool")));
}

TEST_F(StreamErrorsTest, NoStart) {
  EXPECT_THAT(
      PoolStream(channel_).Call(StepRequest({4})),
      StatusIs(absl::StatusCode::kInvalidArgument, "the first request of a stream has no start"));
}

TEST_F(StreamErrorsTest, StreamWithoutRequestsEndsWithOk) {
  EXPECT_THAT(PoolStream(channel_).Close(), IsOk());
}

TEST_F(StreamErrorsTest, NameThatIsTaken) {
  const auto stream = StartPool(MazeSpec(1), "mine");
  EXPECT_THAT(StartError(MazeSpec(1), "mine"),
              StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr("pools/mine")));
  v1::Batch batch;
  EXPECT_THAT(stream->Step({4}, &batch), IsOk());
}

}  // namespace
}  // namespace procgen
