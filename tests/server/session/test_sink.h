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

// Records the results of a request.
class TestSink final : public ResponseSink {
 public:
  // `batch`: the arrays of the whole request, to which all parts are written.
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
  // The kept answer, if the request was executed before.
  const std::optional<Answer>& recalled() const { return recalled_; }

 private:
  const Batch batch_;
  const std::string response_;
  std::vector<Part> parts_;
  std::optional<Answer> recalled_;
  absl::Status status_;
  absl::Notification done_;
};

// A request that arrives now, for the measured request times.
inline Request RequestOf(int64_t sequence_number) {
  Request request;
  request.sequence_number = sequence_number;
  request.arrival_time = SteadyNow();
  return request;
}

// Executes a request and waits until it is done.
inline absl::Status Execute(PoolSession* session, Request request, const Batch& batch = {}) {
  const auto sink = std::make_shared<TestSink>(batch);
  session->Execute(&request, sink);
  return sink->status();
}

}  // namespace procgen

#endif  // TESTS_SERVER_SESSION_TEST_SINK_H_
