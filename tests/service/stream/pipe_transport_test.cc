// The pipe transport: messages of shared-memory streams through pipes instead of gRPC.

#include "procgen_client/internal/pipe_transport.h"

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "gmock/gmock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "gtest/gtest.h"
#include "procgen_client/internal/grpc_error.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/shared_memory_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

// A raw stream and its pipes.
class PipeTransportTest : public SharedMemoryTest {
 protected:
  void SetUp() override {
    SharedMemoryTest::SetUp();
    pool_ = CreatePool(SharedSpec(MazeSpec(2)));
    stub_ = v1::StepService::NewStub(
        grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()));
    stream_ = stub_->StepPool(&context_);
    v1::StepPoolRequest attach;
    attach.mutable_attach()->set_pool(pool_);
    v1::StepPoolResponse response;
    ASSERT_TRUE(stream_->Write(attach));
    ASSERT_TRUE(stream_->Read(&response));
    pipes_ = procgen_client::PipeTransport::Open(
        response.attached().shared_memory().pipe_transport(), 4 << 20, cancellation_);
    ASSERT_NE(pipes_, nullptr);
    // A response through the pipes shows that they are open.
    ASSERT_TRUE(pipes_->Send(Observe(1)));
    ASSERT_TRUE(pipes_->Receive(&response));
    EXPECT_EQ(response.sequence_number(), 1);
    EXPECT_TRUE(response.batch().has_shared_batch());
  }

  static v1::StepPoolRequest Observe(int64_t number) {
    v1::StepPoolRequest request;
    request.set_sequence_number(number);
    request.mutable_observe();
    return request;
  }

  // Returns the status of the stream after its end.
  absl::Status End() {
    v1::StepPoolResponse response;
    EXPECT_FALSE(pipes_->Receive(&response));
    EXPECT_FALSE(stream_->Read(&response));
    return procgen_client::ToAbslStatus(stream_->Finish());
  }

  std::string pool_;
  std::unique_ptr<v1::StepService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StepPoolRequest, v1::StepPoolResponse>> stream_;
  const std::shared_ptr<procgen_client::Cancellation> cancellation_ =
      std::make_shared<procgen_client::Cancellation>(nullptr);
  std::unique_ptr<procgen_client::PipeTransport> pipes_;
};

TEST_F(PipeTransportTest, ReceiveAfterACancellationDoesNotBlock) {
  cancellation_->Cancel();
  v1::StepPoolResponse response;
  EXPECT_FALSE(pipes_->Receive(&response));
  context_.TryCancel();
}

TEST_F(PipeTransportTest, InterruptEndsABlockedReceive) {
  std::thread reader([this] {
    v1::StepPoolResponse response;
    EXPECT_FALSE(pipes_->Receive(&response));
  });
  absl::SleepFor(absl::Milliseconds(50));  // The reader is blocked by then: no request was sent.
  cancellation_->Cancel();
  pipes_->Interrupt();
  reader.join();
  context_.TryCancel();
}

TEST_F(PipeTransportTest, ErrorsEndTheStreamAfterEarlierRequests) {
  ASSERT_TRUE(pipes_->Send(Observe(2)));
  ASSERT_TRUE(pipes_->Send(Observe(99)));
  v1::StepPoolResponse response;
  ASSERT_TRUE(pipes_->Receive(&response));
  EXPECT_EQ(response.sequence_number(), 2);
  EXPECT_THAT(End(), StatusIs(absl::StatusCode::kInvalidArgument,
                              HasSubstr("sequence_number is 99, allowed: 3")));
}

TEST_F(PipeTransportTest, StepsOnTheStreamAreRejectedWhilePipesAreOpen) {
  ASSERT_TRUE(stream_->Write(Observe(2)));
  EXPECT_THAT(
      End(), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("its pipe transport is open")));
}

TEST_F(PipeTransportTest, ClosedPipeEndsTheStream) {
  pipes_->HangUp();
  EXPECT_THAT(End(), IsOk());
  EXPECT_FALSE(client_->GetPool(pool_)->attached());
}

// The server does not watch the pipes during a request.
TEST_F(PipeTransportTest, PipeClosedDuringARequestEndsTheStream) {
  v1::StepPoolRequest request = StepRequest({4, 4});
  request.set_sequence_number(2);
  request.mutable_step()->set_repeat_count(1000);
  ASSERT_TRUE(pipes_->Send(request));
  pipes_->HangUp();
  v1::StepPoolResponse response;
  while (pipes_->Receive(&response)) {
  }
  EXPECT_FALSE(stream_->Read(&response));
  // Usually CANCELLED, because the response could not be sent.
  EXPECT_THAT(stream_->Finish().error_code(),
              testing::AnyOf(grpc::StatusCode::OK, grpc::StatusCode::CANCELLED));
  EXPECT_FALSE(client_->GetPool(pool_)->attached());
  EXPECT_EQ(client_->GetPool(pool_)->next_sequence_number(), 3) << "the request was executed";
}

TEST_F(PipeTransportTest, RequestsQueuedBehindAnotherCallAreExecuted) {
  std::vector<int32_t> seen;
  for (int64_t number = 2; number < 200; number += 2) {
    v1::StepPoolRequest request = Observe(number);
    request.mutable_released_batches()->Assign(seen.begin(), seen.end());
    seen.clear();
    std::thread concurrent([this] { EXPECT_THAT(client_->SaveStates(pool_, {0, 1}), IsOk()); });
    EXPECT_TRUE(pipes_->Send(request));
    EXPECT_TRUE(pipes_->Send(Observe(number + 1)));
    concurrent.join();
    for (const int64_t answered : {number, number + 1}) {
      v1::StepPoolResponse response;
      ASSERT_TRUE(pipes_->Receive(&response));
      EXPECT_EQ(response.sequence_number(), answered);
      seen.push_back(response.batch().shared_batch());
    }
  }
}

TEST_F(PipeTransportTest, EndOfStreamClosesThePipes) {
  ASSERT_TRUE(stream_->WritesDone());
  EXPECT_THAT(End(), IsOk());
}

TEST_F(PipeTransportTest, PipesEndWithTheirPool) {
  EXPECT_THAT(client_->DeletePool(pool_), IsOk());
  EXPECT_THAT(End(), StatusIs(absl::StatusCode::kAborted, HasSubstr("was deleted")));
}

TEST_F(PipeTransportTest, PipesEndWithACancelledStream) {
  context_.TryCancel();
  EXPECT_EQ(End().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace procgen
