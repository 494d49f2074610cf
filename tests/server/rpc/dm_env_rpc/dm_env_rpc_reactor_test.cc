#include "server/rpc/dm_env_rpc/dm_env_rpc_reactor.h"

#include <atomic>
#include <memory>
#include <thread>

#include "absl/time/time.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "grpcpp/support/slice.h"
#include "gtest/gtest.h"
#include "server/dm_env_rpc/joined_world.h"
#include "server/metrics/metrics.h"
#include "server/rpc/auth/authenticator.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/session/pool_supervisor.h"
#include "server/session/quota/limits.h"

namespace procgen {
namespace {

using grpc::ByteBuffer;

// gRPC's side of a call. One request arrives, then the connection breaks while the next read
// starts: another thread reports it.
class BreakingCall final : public grpc::ServerCallbackReaderWriter<ByteBuffer, ByteBuffer> {
 public:
  explicit BreakingCall(grpc::ServerBidiReactor<ByteBuffer, ByteBuffer>* reactor)
      : reactor_(reactor) {
    BindReactor(reactor);
  }
  // Whether the call ended, and so might have been freed, before the read had started.
  bool finished_within_read() const { return finished_within_read_; }
  bool finished() const { return finished_; }

  void Read(ByteBuffer* request) override {
    if (read_count_++ == 0) {
      const grpc::Slice bytes("");
      *request = ByteBuffer(&bytes, 1);
      return;
    }
    std::thread([this] { reactor_->OnCancel(); }).join();
    finished_within_read_ = finished_;
  }
  void Write(const ByteBuffer* /*response*/, grpc::WriteOptions /*options*/) override {
    reactor_->OnWriteDone(true);
  }
  void Finish(grpc::Status /*status*/) override { finished_ = true; }
  void SendInitialMetadata() override {}
  void WriteAndFinish(const ByteBuffer* /*response*/, grpc::WriteOptions /*options*/,
                      grpc::Status /*status*/) override {}

 private:
  grpc::internal::ServerReactor* reactor() override { return reactor_; }
  void CallOnDone() override {}

  grpc::ServerBidiReactor<ByteBuffer, ByteBuffer>* const reactor_;
  int read_count_ = 0;
  std::atomic<bool> finished_ = false;
  bool finished_within_read_ = false;
};

TEST(DmEnvRpcReactorTest, CancellationDoesNotEndItWhileAReadStarts) {
  Metrics metrics("test");
  PoolSupervisor supervisor(Limits(), 1, &metrics);
  JoinedWorlds worlds;
  const CallAccounting accounting(Authenticator(nullptr, false), absl::Seconds(10),
                                  &supervisor.quotas(), &metrics);
  grpc::CallbackServerContext context;
  const std::shared_ptr<grpc::ServerBidiReactor<ByteBuffer, ByteBuffer>> reactor =
      DmEnvRpcReactor::Start(&supervisor, &worlds, &accounting, &context, Caller());
  const BreakingCall call(reactor.get());
  reactor->OnReadDone(true);
  EXPECT_FALSE(call.finished_within_read());
  EXPECT_TRUE(call.finished());
  reactor->OnDone();
}

}  // namespace
}  // namespace procgen
