#ifndef SERVER_RPC_DM_ENV_RPC_DM_ENV_RPC_REACTOR_H_
#define SERVER_RPC_DM_ENV_RPC_DM_ENV_RPC_REACTOR_H_

#include <cstdint>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/dm_env_rpc/dm_env_rpc_session.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// The gRPC reactor of a dm_env_rpc stream, which passes requests to a DmEnvRpcSession.
//
// Requests are answered one at a time. The next one is read meanwhile, but no further one until the
// response is written. The stream ends when its client has half-closed it and all requests are
// answered. After a cancellation or during a drain it ends after the current request.
//
// All decisions are in NextAction, under the lock. Each event records what happened and calls
// Drive, which acts outside of the lock until there is nothing to do.
//
// Threads: gRPC's reactions, answers and End may come from any thread, concurrently.
// Lock order: mutex_ is not held during calls to other objects.
class DmEnvRpcReactor final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                              public std::enable_shared_from_this<DmEnvRpcReactor> {
 public:
  // Starts to serve a stream. The pointers must outlive it.
  static std::shared_ptr<DmEnvRpcReactor> Start(PoolSupervisor* supervisor, JoinedWorlds* worlds,
                                                const CallAccounting* accounting,
                                                grpc::CallbackServerContext* context,
                                                Caller caller);

  // Ends the stream with `status` after the current request.
  void End(const absl::Status& status);

 private:
  enum class Action : uint8_t { kWait, kRead, kAnswer, kWrite, kFinish };

  DmEnvRpcReactor(PoolSupervisor* supervisor, const CallAccounting* accounting,
                  grpc::CallbackServerContext* context, Caller caller);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void Drive();
  Action NextAction() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Act(Action action);

  void Answer();
  void OnAnswered(const absl::Status& status);
  void Write();
  void FinishStream();
  // Stops reading requests. `cancelled`: also stops writing responses.
  void EndNow(const absl::Status& status, bool cancelled);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  grpc::CallbackServerContext* const context_;
  const Caller caller_;
  std::unique_ptr<DmEnvRpcSession> session_;
  std::shared_ptr<DmEnvRpcReactor> self_;  // until OnDone

  grpc::ByteBuffer read_bytes_;       // the next request
  grpc::ByteBuffer request_bytes_;    // the current request
  dm::EnvironmentRequest request_;    // the current request
  dm::EnvironmentResponse response_;  // to the current request, until it is written
  grpc::ByteBuffer written_bytes_;

  absl::Mutex mutex_;
  bool reading_ ABSL_GUARDED_BY(mutex_) = false;
  // Reads that threads are about to start. Until they have, the stream must not end, because gRPC
  // frees a call that has ended.
  int starting_read_count_ ABSL_GUARDED_BY(mutex_) = 0;
  bool has_request_ ABSL_GUARDED_BY(mutex_) = false;  // in read_bytes_
  bool reading_ended_ ABSL_GUARDED_BY(mutex_) = false;
  bool answering_ ABSL_GUARDED_BY(mutex_) = false;
  bool has_response_ ABSL_GUARDED_BY(mutex_) = false;  // in response_, not written yet
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);  // final status of the stream
};

}  // namespace procgen

#endif  // SERVER_RPC_DM_ENV_RPC_DM_ENV_RPC_REACTOR_H_
