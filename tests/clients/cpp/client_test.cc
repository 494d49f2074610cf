#include "procgen_client/client.h"

#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::SizeIs;

class ClientTest : public ServiceTest {};

TEST_F(ClientTest, ConnectingToNobodyFailsInTime) {
  procgen_client::ConnectOptions options;
  options.timeout = absl::Milliseconds(200);
  EXPECT_THAT(
      procgen_client::Client::Connect("127.0.0.1:1", options),
      StatusIs(absl::StatusCode::kUnavailable, "no server answers at 127.0.0.1:1 within 200ms"));
}

TEST_F(ClientTest, ErrorOfAStreamStays) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  procgen_client::Batch batch;
  const absl::Status error = stream->Step({99}, &batch);
  EXPECT_THAT(error, StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("99")));
  EXPECT_EQ(stream->Send(StepRequest({4})).status(), error);
  EXPECT_EQ(stream->Receive(&batch), error);
  EXPECT_EQ(stream->Close(), error);
}

TEST_F(ClientTest, ClosedStreamRefusesAndItsPoolIsFree) {
  const std::string name = CreatePool(MazeSpec(1));
  auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());
  EXPECT_THAT((*stream)->Close(), IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Step({4}, &batch),
              StatusIs(absl::StatusCode::kFailedPrecondition, "the stream is closed"));
  EXPECT_THAT(client_->Attach(name), IsOk());
}

TEST_F(ClientTest, UnansweredRequestsMustBeReceivedBeforeAPlainStep) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Send(StepRequest({4})), IsOk());
  EXPECT_THAT(stream->Step({4}, &batch),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("unanswered")));
  EXPECT_THAT(stream->Receive(&batch), IsOk());
  EXPECT_THAT(stream->Step({4}, &batch), IsOk());
}

TEST_F(ClientTest, NothingToReceiveIsAnError) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  procgen_client::Batch batch;
  EXPECT_THAT(stream->Receive(&batch),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("no request")));
}

TEST_F(ClientTest, AnswerInSeveralResponsesIsJoined) {
  const auto stream = CreateAndAttach(MazeSpec(400));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Step(std::vector<int32_t>(400, 4), &batch), IsOk());
  EXPECT_EQ(batch.first_environment(), 0);
  EXPECT_EQ(batch.environment_count(), 400);
  EXPECT_THAT(batch.episode_lengths(), SizeIs(400));
  EXPECT_THAT(batch.episode_lengths(), Each(1));
  EXPECT_THAT(batch.observations(), SizeIs(400UL * 64 * 64 * 3));
}

TEST_F(ClientTest, DroppedStreamFreesItsPoolWithAnswersUnread) {
  const std::string name = CreatePool(MazeSpec(16));
  {
    const auto stream = client_->Attach(name);
    ASSERT_THAT(stream, IsOk());
    ASSERT_THAT((*stream)->Send(StepRequest(std::vector<int32_t>(16, 4))), IsOk());
  }
  const auto again = client_->Attach(name);
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ((*again)->pool().next_sequence_number(), 2);
}

}  // namespace
}  // namespace procgen
