#ifndef SERVER_RPC_SERVICES_REFLECTION_REACTOR_H_
#define SERVER_RPC_SERVICES_REFLECTION_REACTOR_H_

#include <functional>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/alarm.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"

namespace procgen {

// A stream of ServerReflectionInfo: reads requests and writes their answers alternately, until the
// client half-closes or the request timeout expires.
// Threads: gRPC's reactions run one at a time; the alarm may run concurrently.
class ReflectionReactor final : public ByteStream,
                                public std::enable_shared_from_this<ReflectionReactor> {
 public:
  using Answer = std::function<absl::StatusOr<grpc::ByteBuffer>(const grpc::ByteBuffer&)>;

  // Starts a stream, which lives until OnDone. The pointers must outlive it.
  static ByteStream* Start(const CallAccounting* accounting, grpc::CallbackServerContext* context,
                           Answer answer);

 private:
  ReflectionReactor(const CallAccounting* accounting, grpc::CallbackServerContext* context,
                    Answer answer);

  void OnReadDone(bool ok) override ABSL_LOCKS_EXCLUDED(mutex_);
  void OnWriteDone(bool ok) override ABSL_LOCKS_EXCLUDED(mutex_);
  void OnDone() override;
  void OnTimeout() ABSL_LOCKS_EXCLUDED(mutex_);

  // Ends the stream. No effect if it has ended.
  void End(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const CallAccounting* const accounting_;
  grpc::CallbackServerContext* const context_;
  const Answer answer_;
  grpc::Alarm alarm_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;
  std::shared_ptr<ReflectionReactor> self_;

  absl::Mutex mutex_;
  bool writes_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_REFLECTION_REACTOR_H_
