#ifndef SERVER_RPC_WATCH_LATEST_STREAM_H_
#define SERVER_RPC_WATCH_LATEST_STREAM_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/auth/call_accounting.h"

namespace procgen {

// A stream that sends the latest state, one response at a time. While one is being sent, the latest
// waits and replaces earlier ones, so a client that does not read costs two responses.
// Threads: any method from any thread.
class LatestStream : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  // Ends the stream after the current write. No effect if it has ended.
  void Close(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

 protected:
  // Creates the response. Called when it can be sent.
  using Response = std::function<grpc::ByteBuffer()>;

  // `method`: "SERVICE/METHOD". `accounting` must outlive the stream.
  LatestStream(const CallAccounting* accounting, absl::string_view method);
  ~LatestStream() override = default;

  // Keeps a reference to the stream until OnDone. Call first.
  void Begin(std::shared_ptr<LatestStream> self) { self_ = std::move(self); }

  // Sends a response, or replaces the waiting one.
  void Send(Response response) ABSL_LOCKS_EXCLUDED(mutex_);
  // Whether a response would be sent immediately.
  bool IsIdle() ABSL_LOCKS_EXCLUDED(mutex_);

  // Releases the stream's resources. Called by OnDone.
  virtual void ReleaseSource() = 0;

 private:
  void OnWriteDone(bool ok) final;
  void OnCancel() final;
  void OnDone() final;

  // Writes the waiting response or ends the stream, unless a write is in progress. Calls gRPC
  // without the lock, because it may call back immediately.
  void Continue() ABSL_LOCKS_EXCLUDED(mutex_);

  const CallAccounting* const accounting_;
  const std::string method_;
  std::shared_ptr<LatestStream> self_;
  grpc::ByteBuffer written_;  // by the current write

  absl::Mutex mutex_;
  Response waiting_ ABSL_GUARDED_BY(mutex_);  // null: none
  bool writes_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);  // final status; set by Close
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_LATEST_STREAM_H_
