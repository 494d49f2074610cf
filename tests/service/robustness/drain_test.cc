// A draining server, seen by its clients.

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/raw_call.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class DrainTest : public ServiceTest {};

TEST_F(DrainTest, DrainRejectsCallsAndEndsStreams) {
  const std::string name = CreatePool(MazeSpec(1));
  const auto stream = CreateAndAttach(MazeSpec(1));
  server_is_alive_ = false;
  server_->BeginDrain();
  EXPECT_THAT(CallRaw(channel_, "/grpc.health.v1.Health/Check", {""}).responses,
              testing::ElementsAre("\x08\x02"));  // NOT_SERVING
  EXPECT_THAT(client_->CreatePool(MazeSpec(1)),
              StatusIs(absl::StatusCode::kUnavailable,
                       "the server drains and will stop; use another server"));
  EXPECT_THAT(client_->Attach(name), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  EXPECT_THAT(CallStatus(stream.get(), StepRequest({4})),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  const absl::StatusOr<v1::Load> load = client_->GetLoad();
  ASSERT_THAT(load, IsOk());
  EXPECT_TRUE(load->draining());
}

TEST_F(DrainTest, LearnerThatDoesNotReadIsDisconnectedAtTheTimeout) {
  // The responses are not read, so the running request does not complete.
  const auto stub = v1::StepService::NewStub(channel_);
  grpc::ClientContext context;
  const auto stream = stub->StepPool(&context);
  v1::StepPoolRequest request;
  request.mutable_attach()->set_pool(CreatePool(MazeSpec(400)));
  stream->Write(request);
  v1::StepPoolResponse response;
  ASSERT_TRUE(stream->Read(&response));
  for (int i = 1; i <= 3; ++i) {
    request = StepRequest(std::vector<int32_t>(400, 4));
    request.set_sequence_number(i);
    stream->Write(request);
  }
  server_is_alive_ = false;
  server_->Stop(absl::Milliseconds(100));
  while (stream->Read(&response)) {
  }
  EXPECT_FALSE(stream->Finish().ok());
}

}  // namespace
}  // namespace procgen
