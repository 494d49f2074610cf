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
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/one_request_stream.h"

namespace procgen {

// A stream of the latest state, one response at a time: while one is being sent the latest waits
// and replaces earlier ones. So a client that does not read costs two responses. Threads: any
// method from any thread.
class LatestStream : public OneRequestStream {
 public:
  // Ends the stream, once what is being sent is on its way, unless it has ended.
  void Close(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

 protected:
  // Makes a response, when it can be sent.
  using Response = std::function<grpc::ByteBuffer()>;

  // `method`: "SERVICE/METHOD". `accounting` must outlive the stream.
  LatestStream(const CallAccounting* accounting, absl::string_view method);
  ~LatestStream() override = default;

  // Begins: reads the request, and holds the stream until gRPC has done with it. It may live longer
  // if somebody else holds it.
  void Begin(std::shared_ptr<LatestStream> self);

  // Sends a response, or replaces the waiting one.
  void Send(Response response) ABSL_LOCKS_EXCLUDED(mutex_);
  // Whether a response would be sent at once.
  bool IsIdle() ABSL_LOCKS_EXCLUDED(mutex_);

  // Releases the stream's resources after gRPC is done with it.
  virtual void ReleaseSource() = 0;

 private:
  void OnWriteDone(bool ok) final;
  void OnCancel() final;
  void OnDone() final;

  // Writes, or ends, if there is reason to and no write is under way. gRPC is called without the
  // lock, since it may call back at once.
  void Continue() ABSL_LOCKS_EXCLUDED(mutex_);

  const CallAccounting* const accounting_;
  const std::string method_;
  std::shared_ptr<LatestStream> self_;
  grpc::ByteBuffer written_;  // by the write under way

  absl::Mutex mutex_;
  Response waiting_ ABSL_GUARDED_BY(mutex_);  // null: none
  bool writes_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);  // that it is to end with
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_LATEST_STREAM_H_
