// Requesting responses again, and taking over, message by message.

#include <memory>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/raw_stream.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class ResumeTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    stub_ = v1::StepService::NewStub(channel_);
  }

  std::unique_ptr<RawStream> Open(const std::string& pool, bool resumable = true,
                                  int64_t response_bytes_max = 0) {
    v1::Attach attach;
    attach.set_pool(pool);
    attach.set_resumable(resumable);
    attach.set_take_over(true);
    attach.set_response_bytes_max(response_bytes_max);
    return std::make_unique<RawStream>(stub_.get(), attach);
  }

  std::unique_ptr<v1::StepService::Stub> stub_;
};

TEST_F(ResumeTest, RepeatedRequestReturnsTheSameResponse) {
  const std::string pool = CreatePool(MazeSpec(2));
  const auto first = Open(pool);
  EXPECT_EQ(first->Receive().attached().oldest_kept_sequence_number(), 1);
  first->Send(StepRequest({7, -1}), 1);
  const v1::StepPoolResponse answer = first->Receive();
  first->Break();

  const auto second = Open(pool);
  const v1::StepPoolResponse attached = second->Receive();
  EXPECT_EQ(attached.attached().next_sequence_number(), 2);
  EXPECT_EQ(attached.attached().oldest_kept_sequence_number(), 1);
  second->Send(StepRequest({7, -1}), 1);
  EXPECT_EQ(second->Receive().SerializeAsString(), answer.SerializeAsString());
  second->Send(StepRequest({4, 4}), 2);
  EXPECT_EQ(second->Receive().batch().episode_lengths(0), 2);
}

TEST_F(ResumeTest, ChunkedResponseIsKeptWhole) {
  const std::string pool = CreatePool(MazeSpec(12));
  const auto first = Open(pool, /*resumable=*/true, /*response_bytes_max=*/65536);
  first->Receive();
  first->Send(StepRequest(std::vector<int32_t>(12, 7)), 1);
  std::vector<std::string> answer;
  answer.reserve(3);
  for (int i = 0; i < 3; ++i) {
    answer.push_back(first->Receive().SerializeAsString());
  }
  first->Break();

  const auto second = Open(pool, /*resumable=*/true, /*response_bytes_max=*/65536);
  second->Receive();
  second->Send(StepRequest(std::vector<int32_t>(12, 7)), 1);
  for (const std::string& response : answer) {
    EXPECT_EQ(second->Receive().SerializeAsString(), response);
  }
}

TEST_F(ResumeTest, AcceptedRequestIsExecutedAfterTheBreak) {
  // Probably still running when the stream breaks; the result is the same if not.
  v1::StepPoolRequest request = StepRequest(std::vector<int32_t>(40, 4));
  request.mutable_step()->set_repeat_count(50);
  const std::string pool = CreatePool(MazeSpec(40));
  const auto first = Open(pool);
  first->Receive();
  first->Send(request, 1);
  first->Send(request, 2);
  first->Receive();
  first->Break();

  const auto second = Open(pool);
  second->Receive();
  second->Send(request, 2);
  const v1::StepPoolResponse answer = second->Receive();
  EXPECT_EQ(answer.sequence_number(), 2);
  EXPECT_EQ(answer.batch().episode_lengths(0), 100);
}

TEST_F(ResumeTest, ResumeBeyondTheBufferIsRejectedWithItsRange) {
  const std::string pool = CreatePool(MazeSpec(1));
  const auto stream = Open(pool);
  stream->Receive();
  for (const int64_t number : {1, 2, 3}) {
    stream->Send(StepRequest({4}), number);
    stream->Receive();
  }
  stream->Send(StepRequest({4}), 1);
  EXPECT_THAT(stream->Finish(), StatusIs(absl::StatusCode::kFailedPrecondition,
                                         HasSubstr("is not kept; kept: 2 to 3, the next: 4")));
}

TEST_F(ResumeTest, AcknowledgedResponsesAreDropped) {
  const std::string pool = CreatePool(MazeSpec(1));
  const auto stream = Open(pool);
  stream->Receive();
  stream->Send(StepRequest({4}), 1);
  stream->Receive();
  stream->Send(StepRequest({4}), 2, /*acknowledged=*/1);
  stream->Receive();
  stream->Send(StepRequest({4}), 1);
  EXPECT_THAT(stream->Finish(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("kept: 2 to 2")));
}

TEST_F(ResumeTest, NonResumableStreamKeepsNothing) {
  const std::string pool = CreatePool(MazeSpec(1));
  const auto stream = Open(pool, /*resumable=*/false);
  stream->Receive();
  stream->Send(StepRequest({4}), 1);
  stream->Receive();
  stream->Send(StepRequest({4}), 1);
  EXPECT_THAT(stream->Finish(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("kept: none")));
}

TEST_F(ResumeTest, KeptResponseTooLargeForTheNewStreamIsRejected) {
  const std::string pool = CreatePool(MazeSpec(12));
  const auto first = Open(pool);
  first->Receive();
  first->Send(StepRequest(std::vector<int32_t>(12, 7)), 1);
  first->Receive();
  first->Break();
  const auto second = Open(pool, /*resumable=*/true, /*response_bytes_max=*/65536);
  second->Receive();
  second->Send(StepRequest(std::vector<int32_t>(12, 7)), 1);
  EXPECT_THAT(second->Finish(), StatusIs(absl::StatusCode::kResourceExhausted,
                                         HasSubstr("limit attach.response_bytes_max is 65536")));
}

TEST_F(ResumeTest, StreamThatIsTakenOverIsAborted) {
  const std::string pool = CreatePool(MazeSpec(1));
  const auto first = Open(pool);
  first->Receive();
  const auto second = Open(pool);
  second->Receive();
  EXPECT_THAT(first->Finish(),
              StatusIs(absl::StatusCode::kAborted, "another stream took over pool " + pool));
  second->Send(StepRequest({4}), 1);
  EXPECT_EQ(second->Receive().sequence_number(), 1);
}

TEST_F(ResumeTest, LearnerThatDoesNotReadCanBeTakenOver) {
  // Responses of 5 MB fill the connection, so the second waits until the first is written.
  const std::vector<int32_t> actions(400, 4);
  const std::string pool = CreatePool(MazeSpec(400));
  const auto unread = Open(pool);
  unread->Receive();
  unread->Send(StepRequest(actions), 1);
  unread->Send(StepRequest(actions), 2);
  while (client_->GetPool(pool)->next_sequence_number() < 3) {
  }
  const auto other_client = Connect();
  const auto stream = other_client->Attach(pool, {.take_over = true});
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Step(actions, &batch), IsOk());
  EXPECT_EQ(batch.episode_lengths()[0], 3);
}

TEST_F(ResumeTest, ManyTakeoversAllEnd) {
  const std::string pool = CreatePool(MazeSpec(1));
  std::vector<std::unique_ptr<RawStream>> streams;
  for (int i = 0; i < 20; ++i) {
    streams.push_back(Open(pool));
    streams.back()->HalfClose();
  }
  for (const auto& stream : streams) {
    EXPECT_THAT(stream->Finish(), testing::AnyOf(IsOk(), StatusIs(absl::StatusCode::kAborted,
                                                                  HasSubstr("took over"))));
  }
  EXPECT_FALSE(client_->GetPool(pool)->attached());
}

}  // namespace
}  // namespace procgen
