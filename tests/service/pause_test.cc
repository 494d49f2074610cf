// Pausing pools: PausePool.

#include <memory>
#include <string>
#include <thread>

#include "gmock/gmock.h"
#include "grpcpp/client_context.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

// A stream of PausePool.
class Pause {
 public:
  Pause(const std::shared_ptr<grpc::Channel>& channel, const std::string& pool)
      : stub_(v1::PoolService::NewStub(channel)), stream_(stub_->PausePool(&context_)) {
    Send(pool);
  }
  ~Pause() { context_.TryCancel(); }
  Pause(const Pause&) = delete;
  Pause& operator=(const Pause&) = delete;

  void Send(const std::string& name = "") {
    v1::PausePoolRequest request;
    request.set_name(name);
    stream_->Write(request);
  }
  // Whether the last request was answered; the stream has ended otherwise.
  bool IsAnswered() {
    v1::PausePoolResponse response;
    return stream_->Read(&response);
  }
  void HalfClose() { stream_->WritesDone(); }
  grpc::Status Finish() { return stream_->Finish(); }

 private:
  grpc::ClientContext context_;
  const std::unique_ptr<v1::PoolService::Stub> stub_;
  const std::unique_ptr<grpc::ClientReaderWriter<v1::PausePoolRequest, v1::PausePoolResponse>>
      stream_;
};

class PauseTest : public ServiceTest {
 protected:
  bool IsPaused(const std::string& name) { return client_->GetPool(name)->paused(); }
  int64_t RequestCount(const std::string& name) { return client_->GetPool(name)->request_count(); }
  // Reads a pool twenty times in a row; a request that may pass would have.
  void ExpectNoRequestPasses(const std::string& name, int64_t request_count) {
    for (int i = 0; i < 20; ++i) {
      EXPECT_EQ(RequestCount(name), request_count);
    }
  }
};

TEST_F(PauseTest, RequestsWaitAndPassOneByOne) {
  const auto stream = StartPool(MazeSpec(1));
  Pause pause(channel_, stream->name());
  ASSERT_TRUE(pause.IsAnswered());
  EXPECT_TRUE(IsPaused(stream->name()));
  for (int i = 0; i < 3; ++i) {
    stream->Write(StepRequest({4}));
  }
  ExpectNoRequestPasses(stream->name(), 0);
  EXPECT_THAT(stream->name(), HasSubstr("pools/"));
  for (int64_t count = 1; count <= 2; ++count) {
    pause.Send();
    ASSERT_TRUE(pause.IsAnswered());
    v1::Batch batch;
    ASSERT_THAT(stream->Read(&batch), IsOk());
    EXPECT_EQ(batch.episode_lengths(0), count);
    ExpectNoRequestPasses(stream->name(), count);
  }
  pause.HalfClose();
  v1::Batch batch;
  ASSERT_THAT(stream->Read(&batch), IsOk());
  EXPECT_EQ(batch.episode_lengths(0), 3);
  EXPECT_FALSE(pause.IsAnswered());
  EXPECT_TRUE(pause.Finish().ok());
  EXPECT_FALSE(IsPaused(stream->name()));
}

TEST_F(PauseTest, APausedPoolEndsWithItsStreamAndEndsThePause) {
  auto stream = StartPool(MazeSpec(1));
  Pause pause(channel_, stream->name());
  ASSERT_TRUE(pause.IsAnswered());
  stream->Write(StepRequest({4}));
  stream.reset();
  EXPECT_FALSE(pause.IsAnswered());
  const grpc::Status status = pause.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_THAT(status.error_message(), HasSubstr("ended with its stream"));
}

TEST_F(PauseTest, ADrainEndsPauses) {
  const auto server = StartServer(1);
  const auto channel = ChannelTo(server->address());
  PoolStream stream(channel);
  ASSERT_THAT(stream.Start(MazeSpec(1)), IsOk());
  Pause pause(channel, stream.name());
  ASSERT_TRUE(pause.IsAnswered());
  server->BeginDrain();
  EXPECT_FALSE(pause.IsAnswered());
  EXPECT_EQ(pause.Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  Pause late(channel, "pools/1");
  EXPECT_EQ(late.Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(PauseTest, InvalidRequestsEndTheStreamAndThePause) {
  const auto stream = StartPool(MazeSpec(1), "mine");
  Pause missing(channel_, "pools/none");
  EXPECT_EQ(missing.Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  Pause malformed(channel_, "none");
  EXPECT_EQ(malformed.Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  Pause again(channel_, "pools/mine");
  ASSERT_TRUE(again.IsAnswered());
  again.Send("pools/mine");
  EXPECT_FALSE(again.IsAnswered());
  EXPECT_EQ(again.Finish().error_message(),
            "name is 'pools/mine' again, allowed: empty in further requests");
  EXPECT_FALSE(IsPaused("pools/mine"));
}

}  // namespace
}  // namespace procgen
