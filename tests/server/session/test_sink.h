#ifndef TESTS_SERVER_SESSION_TEST_SINK_H_
#define TESTS_SERVER_SESSION_TEST_SINK_H_

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "absl/synchronization/notification.h"
#include "server/concurrency/steady_time.h"
#include "server/session/backend/request.h"
#include "server/session/pool/pool_session.h"
#include "server/session/pool/response_sink.h"

namespace procgen {

// Notes what a PoolSession makes of a request.
class TestSink final : public ResponseSink {
 public:
  // The values of parts are written to `batch`, which is for all of the request.
  explicit TestSink(const Batch& batch = {}, std::string response = "response")
      : batch_(batch), response_(std::move(response)) {}

  absl::StatusOr<std::optional<Batch>> PreparePart(Part /*part*/) override { return batch_; }
  absl::Cord PartDone(Part part, bool /*keep*/) override {
    parts_.push_back(part);
    return absl::Cord(response_);
  }
  absl::Status Recall(const Answer& answer) override {
    recalled_ = answer;
    return absl::OkStatus();
  }
  void Done(const absl::Status& status) override {
    status_ = status;
    done_.Notify();
  }

  // Waits for Done.
  const absl::Status& status() {
    done_.WaitForNotification();
    return status_;
  }
  const std::vector<Part>& parts() const { return parts_; }
  // The answer of a request that was executed before.
  const std::optional<Answer>& recalled() const { return recalled_; }

 private:
  const Batch batch_;
  const std::string response_;
  std::vector<Part> parts_;
  std::optional<Answer> recalled_;
  absl::Status status_;
  absl::Notification done_;
};

// A request that arrives now: the times that requests take are added up.
inline Request RequestOf(int64_t sequence_number) {
  Request request;
  request.sequence_number = sequence_number;
  request.arrival_time = SteadyNow();
  return request;
}

// Executes a request, and waits for its end.
inline absl::Status Execute(PoolSession* session, Request request, const Batch& batch = {}) {
  const auto sink = std::make_shared<TestSink>(batch);
  session->Execute(&request, sink);
  return sink->status();
}

}  // namespace procgen

#endif  // TESTS_SERVER_SESSION_TEST_SINK_H_
