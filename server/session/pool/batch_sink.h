#ifndef SERVER_SESSION_POOL_BATCH_SINK_H_
#define SERVER_SESSION_POOL_BATCH_SINK_H_

#include <optional>
#include <utility>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "server/session/pool/response_sink.h"

namespace procgen {

// Writes a whole request to one batch, for callers in this process.
class BatchSink final : public ResponseSink {
 public:
  using OnDone = absl::AnyInvocable<void(absl::Status)>;

  // Memory that `batch` refers to must stay valid until `done`, which is called once.
  BatchSink(const Batch& batch, OnDone done) : batch_(batch), done_(std::move(done)) {}

  absl::StatusOr<std::optional<Batch>> PreparePart(Part /*part*/) override { return batch_; }
  absl::Cord PartDone(Part /*part*/, bool /*keep*/) override { return {}; }
  absl::Status Recall(const Answer& /*answer*/) override {
    return absl::InternalError("a request of this process was executed before");
  }
  void Done(const absl::Status& status) override { done_(status); }

 private:
  const Batch batch_;
  OnDone done_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_BATCH_SINK_H_
