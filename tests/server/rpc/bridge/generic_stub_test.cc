#include "server/rpc/bridge/generic_stub.h"

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/synchronization/mutex.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

// Waits for what happens in a call.
class Events final : public GenericCallObserver {
 public:
  void OnMessage(std::string message) override {
    absl::MutexLock lock(&mutex_);
    messages_.push_back(std::move(message));
  }
  void OnWritten() override {
    absl::MutexLock lock(&mutex_);
    ++written_count_;
  }
  void OnEnd(const CallEnd& end) override {
    absl::MutexLock lock(&mutex_);
    EXPECT_FALSE(end_.has_value());
    end_ = end;
  }

  std::string AwaitMessage() {
    const auto has_message = [this]()
                                 ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return !messages_.empty(); };
    absl::MutexLock lock(&mutex_, absl::Condition(&has_message));
    std::string message = std::move(messages_.front());
    messages_.pop_front();
    return message;
  }
  void AwaitWritten(int count) {
    const auto are_written = [&]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return written_count_ == count;
    };
    absl::MutexLock lock(&mutex_, absl::Condition(&are_written));
  }
  CallEnd AwaitEnd() {
    const auto has_ended = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return end_.has_value(); };
    absl::MutexLock lock(&mutex_, absl::Condition(&has_ended));
    return *end_;
  }
  bool HasEnded() {
    absl::MutexLock lock(&mutex_);
    return end_.has_value();
  }

 private:
  absl::Mutex mutex_;
  std::deque<std::string> messages_ ABSL_GUARDED_BY(mutex_);
  int written_count_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<CallEnd> end_ ABSL_GUARDED_BY(mutex_);
};

class GenericStubTest : public ServiceTest {
 protected:
  // Starts a call. Null: an error, which has failed the test.
  static std::shared_ptr<GenericCall> Start(GenericStub* stub, const std::string& method,
                                            const std::shared_ptr<Events>& events) {
    auto call = stub->Start("/procgen.v1." + method, "", events);
    EXPECT_THAT(call.status(), IsOk());
    return call.value_or(nullptr);
  }
  static std::shared_ptr<GenericCall> StartRun(GenericStub* stub,
                                               const std::shared_ptr<Events>& events) {
    auto call = Start(stub, "PoolService/RunPool", events);
    call->Write(StartRequest(MazeSpec(1)).SerializeAsString());
    call->Read();
    v1::RunPoolResponse response;
    EXPECT_TRUE(response.ParseFromString(events->AwaitMessage()));
    EXPECT_TRUE(response.has_started());
    events->AwaitWritten(1);
    return call;
  }
};

TEST_F(GenericStubTest, CancelledCallsEndWithAndWithoutARead) {
  const auto stub = server_->MakeStub();
  for (const bool reads : {false, true}) {
    const auto events = std::make_shared<Events>();
    const auto call = StartRun(stub.get(), events);
    if (reads) {
      call->Read();
    }
    call->Cancel();
    EXPECT_THAT(events->AwaitEnd().status, StatusIs(absl::StatusCode::kCancelled, testing::_));
    // Without effect now.
    call->Cancel();
    call->Read();
    call->Write("late");
    call->HalfClose();
  }
}

TEST_F(GenericStubTest, StubWaitsForItsCalls) {
  const auto events = std::make_shared<Events>();
  {
    const auto stub = server_->MakeStub();
    for (int i = 0; i < 50; ++i) {
      StartRun(stub.get(), std::make_shared<Events>())->Cancel();
    }
    StartRun(stub.get(), events)->Cancel();
  }
  EXPECT_TRUE(events->HasEnded());
}

TEST_F(GenericStubTest, ErrorsHaveCodeMessageAndWhetherTheServerDrains) {
  const auto stub = server_->MakeStub();
  auto events = std::make_shared<Events>();
  auto call = Start(stub.get(), "PoolService/RunPool", events);
  call->Write("\xff");
  call->Read();
  EXPECT_THAT(events->AwaitEnd().status,
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("not a valid")));
  EXPECT_FALSE(events->AwaitEnd().is_draining);
  const auto server = StartServer(1);
  const auto other = server->MakeStub();
  events = std::make_shared<Events>();
  call = StartRun(other.get(), events);
  server->BeginDrain();
  call->Read();
  EXPECT_THAT(events->AwaitEnd().status, StatusIs(absl::StatusCode::kUnavailable, testing::_));
  EXPECT_TRUE(events->AwaitEnd().is_draining);
}

}  // namespace
}  // namespace procgen
