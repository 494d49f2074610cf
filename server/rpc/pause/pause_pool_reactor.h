#ifndef SERVER_RPC_PAUSE_PAUSE_POOL_REACTOR_H_
#define SERVER_RPC_PAUSE_PAUSE_POOL_REACTOR_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/support/server_callback.h"
#include "procgen/v1/pool_service.pb.h"
#include "server/pool/pool_observer.h"
#include "server/pool/pool_session.h"
#include "server/pool/pool_supervisor.h"
#include "server/pool/quota/quotas.h"
#include "server/rpc/auth/call_accounting.h"

namespace procgen {

// One stream of PausePool. Handles one request at a time:
//
//  1. The first one pauses the pool, and is answered in a turn of the pool, so after the request
//     that the learner had in progress.
//  2. Each further one lets a request of the learner pass.
//  3. The pause ends with the stream, whatever ended it: half-close, cancellation, an error, the
//  end
//     of the pool (reported to observers) or of the server.
//
// Threads: gRPC's and the pool's.
class PausePoolReactor final
    : public grpc::ServerBidiReactor<v1::PausePoolRequest, v1::PausePoolResponse>,
      public PoolObserver,
      public std::enable_shared_from_this<PausePoolReactor> {
 public:
  // Starts a stream, which lives at least until OnDone. The pointers must outlive it.
  static PausePoolReactor* Start(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                 Caller caller);

  // PoolObserver: reports the end of the pool.
  void OnExecuted(const Request& /*request*/, const StepInput& /*input*/, const Batch& /*batch*/,
                  int64_t /*request_count*/, int64_t /*change_number*/) override {}
  void OnInvalidated() override {}
  void OnEnd(const absl::Status& reason) override;

 private:
  PausePoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting, Caller caller);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  // Pauses the pool of the first request.
  absl::Status Pause();
  void Respond() ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends the pause and, after the current write, the stream. No effect if it has ended.
  void End(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void Finish(const absl::Status& status);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  const std::string owner_;
  // Without Caller::under_way, because a drain does not wait for pauses.
  Quotas::Reservation reservation_;
  std::shared_ptr<PausePoolReactor> self_;
  v1::PausePoolRequest request_;
  const v1::PausePoolResponse response_;

  absl::Mutex mutex_;
  std::shared_ptr<PoolSession> pool_ ABSL_GUARDED_BY(mutex_);  // null until it is observed
  bool is_paused_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_writing_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_RPC_PAUSE_PAUSE_POOL_REACTOR_H_
