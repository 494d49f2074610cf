#ifndef TESTS_SERVER_POOL_TEST_SINK_H_
#define TESTS_SERVER_POOL_TEST_SINK_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/synchronization/notification.h"
#include "server/concurrency/steady_time.h"
#include "server/pool/pool_session.h"
#include "server/pool/request.h"
#include "server/pool/response_sink.h"

namespace procgen {

// Records the results of a request.
class TestSink final : public ResponseSink {
 public:
  // `batch`: the memory for the results.
  explicit TestSink(const Batch& batch = {}) : batch_(batch) {}

  Batch Prepare() override { return batch_; }
  void Done(const absl::Status& status) override {
    status_ = status;
    done_.Notify();
  }

  bool is_done() const { return done_.HasBeenNotified(); }
  // Waits for Done.
  const absl::Status& status() {
    done_.WaitForNotification();
    return status_;
  }

 private:
  const Batch batch_;
  absl::Status status_;
  absl::Notification done_;
};

// A request for the first `count` environments. It arrives now, for the measured request times.
inline Request RequestOf(Request::Kind kind, int32_t count) {
  Request request;
  request.kind = kind;
  request.count = count;
  request.arrival_time = SteadyNow();
  return request;
}

}  // namespace procgen

#endif  // TESTS_SERVER_POOL_TEST_SINK_H_
