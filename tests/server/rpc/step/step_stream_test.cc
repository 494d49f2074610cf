#include "server/rpc/step/step_stream.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "gtest/gtest.h"
#include "server/metrics/metrics.h"
#include "server/session/pool_supervisor.h"
#include "server/session/quota/limits.h"

namespace procgen {
namespace {

// A transport whose connection breaks while a read starts: another thread reports it, as gRPC does.
class BreakingTransport final : public StreamTransport {
 public:
  explicit BreakingTransport(const std::atomic<bool>* ended) : ended_(ended) {}
  void set_stream(StepStream* stream) { stream_ = stream; }
  // Whether the stream ended, and so might have freed this, before the read had started.
  bool ended_within_read() const { return ended_within_read_; }

  bool Read() override {
    std::thread([this] { stream_->OnCancel(); }).join();
    ended_within_read_ = *ended_;
    return true;
  }
  absl::Status Parse(StreamRequest* /*request*/) override { return absl::OkStatus(); }
  void Write(Outgoing* /*outgoing*/) override {}

 private:
  const std::atomic<bool>* const ended_;
  StepStream* stream_ = nullptr;
  bool ended_within_read_ = false;
};

TEST(StepStreamTest, CancellationDoesNotEndItWhileAReadStarts) {
  Metrics metrics("test");
  PoolSupervisor supervisor(Limits(), 1, &metrics);
  std::atomic<bool> ended = false;
  BreakingTransport transport(&ended);
  const auto stream = std::make_shared<StepStream>(
      StepStream::Context{.supervisor = &supervisor,
                          .peer = "ipv4:127.0.0.1:1",
                          .transport = &transport,
                          .end = [&](const absl::Status& /*status*/) { ended = true; }},
      Caller());
  transport.set_stream(stream.get());
  stream->Start();
  EXPECT_FALSE(transport.ended_within_read());
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace procgen
