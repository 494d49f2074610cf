// All errors that a request on a stream can cause: code and message. After each the pool is
// unchanged and can be attached again. The fixture checks the server and another pool.

#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class StreamErrorsTest : public ServiceTest {
 protected:
  // Sends an invalid request and checks that the pool is unchanged.
  void ExpectRejected(v1::StepPoolRequest request, absl::StatusCode code,
                      const testing::Matcher<std::string>& message) {
    const std::string name = CreatePool(MazeSpec(4));
    {
      const auto stream = client_->Attach(name);
      ASSERT_THAT(stream, IsOk());
      EXPECT_THAT(CallStatus(stream->get(), std::move(request)), StatusIs(code, message));
    }
    const auto again = client_->Attach(name);
    ASSERT_THAT(again, IsOk());
    EXPECT_EQ((*again)->pool().next_sequence_number(), 1);
    procgen_client::Batch batch;
    EXPECT_THAT((*again)->Step({4, 4, 4, 4}, &batch), IsOk());
    EXPECT_THAT(batch.episode_lengths(), testing::Each(1));
  }

  // Sends these requests on a raw stream; returns its status.
  absl::Status RunRequests(const std::vector<v1::StepPoolRequest>& requests) {
    const auto stub = v1::StepService::NewStub(channel_);
    grpc::ClientContext context;
    const auto stream = stub->StepPool(&context);
    for (const v1::StepPoolRequest& request : requests) {
      stream->Write(request);
    }
    stream->WritesDone();
    v1::StepPoolResponse response;
    while (stream->Read(&response)) {
    }
    const grpc::Status status = stream->Finish();
    return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
  }
};

TEST_F(StreamErrorsTest, WrongNumberOfActions) {
  ExpectRejected(StepRequest({4, 4, 4}), absl::StatusCode::kInvalidArgument,
                 HasSubstr("actions has 3 entries, the slice of pool pools/2 has 4 environments"));
}

TEST_F(StreamErrorsTest, ActionTooLarge) {
  ExpectRejected(StepRequest({4, 15, 4, 4}), absl::StatusCode::kInvalidArgument,
                 "actions[1] is 15, allowed: -1 to 14");
}

TEST_F(StreamErrorsTest, ActionTooSmall) {
  ExpectRejected(StepRequest({4, 4, 4, -2}), absl::StatusCode::kInvalidArgument,
                 "actions[3] is -2, allowed: -1 to 14");
}

TEST_F(StreamErrorsTest, SliceOutOfRange) {
  ExpectRejected(SliceStepRequest(2, 3, 4), absl::StatusCode::kInvalidArgument,
                 "slice.env_count is 3, from environment 2 on pool pools/2 has 2");
}

TEST_F(StreamErrorsTest, SliceStartOutOfRange) {
  ExpectRejected(SliceStepRequest(4, 1, 4), absl::StatusCode::kInvalidArgument,
                 "slice.first_env is 4, pool pools/2 has environments 0 to 3");
}

TEST_F(StreamErrorsTest, NegativeSlice) {
  v1::StepPoolRequest request = StepRequest({4});
  request.mutable_step()->mutable_slice()->set_env_count(-1);
  ExpectRejected(request, absl::StatusCode::kInvalidArgument, HasSubstr("slice.env_count is -1"));
}

TEST_F(StreamErrorsTest, RepeatOutOfRange) {
  v1::StepPoolRequest request = StepRequest({4, 4, 4, 4});
  request.mutable_step()->set_repeat_count(1001);
  ExpectRejected(request, absl::StatusCode::kInvalidArgument,
                 "repeat_count is 1001, allowed: 1 to 1000");
}

TEST_F(StreamErrorsTest, NextLevelOfAnEnvironmentOutOfRange) {
  v1::StepPoolRequest request = StepRequest({4, 4, 4, 4});
  request.mutable_step()->add_next_levels()->set_environment(4);
  ExpectRejected(request, absl::StatusCode::kInvalidArgument,
                 "next_levels[0].environment is 4, the slice is 0 to 3");
}

TEST_F(StreamErrorsTest, ResetOfAnEnvironmentTwice) {
  v1::StepPoolRequest request;
  request.mutable_reset()->add_resets()->set_environment(1);
  request.mutable_reset()->add_resets()->set_environment(1);
  ExpectRejected(request, absl::StatusCode::kInvalidArgument,
                 "resets[1].environment is 1 again, allowed: each at most once");
}

TEST_F(StreamErrorsTest, EmptyRequest) {
  ExpectRejected(v1::StepPoolRequest(), absl::StatusCode::kInvalidArgument,
                 HasSubstr("the request is empty"));
}

TEST_F(StreamErrorsTest, SecondAttach) {
  v1::StepPoolRequest request;
  request.mutable_attach()->set_pool("pools/2");
  ExpectRejected(request, absl::StatusCode::kInvalidArgument,
                 "attach was sent again, allowed: once, as the first request of a stream");
}

TEST_F(StreamErrorsTest, LevelSamplerWithoutLevels) {
  v1::StepPoolRequest request;
  request.mutable_level_sampler();
  ExpectRejected(request, absl::StatusCode::kInvalidArgument,
                 "level_sampler.level_seeds has 0 entries, must have 1 to 1000000");
}

TEST_F(StreamErrorsTest, NoAttach) {
  v1::StepPoolRequest request = StepRequest({4});
  request.set_sequence_number(1);
  EXPECT_THAT(RunRequests({request}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "the first request of a stream has no attach; name the pool there"));
}

TEST_F(StreamErrorsTest, UnknownPool) {
  EXPECT_THAT(client_->Attach("pools/nothing"),
              StatusIs(absl::StatusCode::kNotFound, "there is no pool pools/nothing"));
}

TEST_F(StreamErrorsTest, SecondStreamOnAPool) {
  const std::string name = CreatePool(MazeSpec(1));
  const auto first = client_->Attach(name);
  ASSERT_THAT(first, IsOk());
  EXPECT_THAT(client_->Attach(name), StatusIs(absl::StatusCode::kFailedPrecondition,
                                              "another stream is attached to pool " + name +
                                                  ", allowed: one at a time; end that one, or "
                                                  "attach with take_over"));
  procgen_client::Batch batch;
  EXPECT_THAT((*first)->Step({4}, &batch), IsOk());
}

TEST_F(StreamErrorsTest, SequenceNumberGap) {
  v1::StepPoolRequest attach;
  attach.mutable_attach()->set_pool(CreatePool(MazeSpec(1)));
  v1::StepPoolRequest step = StepRequest({4});
  step.set_sequence_number(2);
  EXPECT_THAT(RunRequests({attach, step}), StatusIs(absl::StatusCode::kInvalidArgument,
                                                    HasSubstr("sequence_number is 2, allowed: 1")));
  step.set_sequence_number(1);
  EXPECT_THAT(RunRequests({attach, step, step}),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("kept: none")));
  attach.set_sequence_number(1);
  EXPECT_THAT(RunRequests({attach}), StatusIs(absl::StatusCode::kInvalidArgument,
                                              "sequence_number is 1 with attach, allowed: 0"));
}

TEST_F(StreamErrorsTest, RequestsBeforeTheInvalidOneAreAnswered) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  ASSERT_THAT(stream->Send(StepRequest({4})), IsOk());
  ASSERT_THAT(stream->Send(StepRequest({99})), IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT(stream->Receive(&batch), IsOk());
  EXPECT_EQ(batch.sequence_number(), 1);
  EXPECT_THAT(stream->Receive(&batch),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("actions[0] is 99")));
}

TEST_F(StreamErrorsTest, EndedEpisodeIsNotSteppedWithoutAutoreset) {
  v1::PoolSpec spec = MazeSpec(2);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const auto stream = CreateAndAttach(spec);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Step({4, -1}, &batch), IsOk());
  EXPECT_THAT(batch.terminated(), testing::ElementsAre(false, true));
  EXPECT_THAT(CallStatus(stream.get(), StepRequest({4, 4})),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("the episode of environment 1 of pool")));
}

TEST_F(StreamErrorsTest, StreamOfADeletedPoolEnds) {
  const std::string name = CreatePool(MazeSpec(1));
  const auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());
  ASSERT_THAT(client_->DeletePool(name), IsOk());
  EXPECT_THAT(CallStatus(stream->get(), StepRequest({4})),
              StatusIs(absl::StatusCode::kAborted, "pool " + name + " was deleted"));
}

}  // namespace
}  // namespace procgen
