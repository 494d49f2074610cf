#ifndef SERVER_RPC_STEP_ATTACH_H_
#define SERVER_RPC_STEP_ATTACH_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/functional/any_invocable.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "procgen/v1/step.pb.h"
#include "server/session/pool/pool_session.h"
#include "server/session/pool_supervisor.h"
#include "server/session/quota/limits.h"

namespace procgen {

// Options of an attached stream.
struct StreamOptions {
  AttachOptions attach;
  int64_t response_bytes_max = 0;
};

// Returns the options of a stream's first request. Errors: INVALID_ARGUMENT it has no attach or an
// invalid value; RESOURCE_EXHAUSTED a value exceeds a limit.
absl::StatusOr<StreamOptions> ReadAttach(const v1::StepPoolRequest& request, const Limits& limits);

// The pool that a stream is attached to.
struct Attachment {
  std::shared_ptr<PoolSession> pool;
  StreamOptions stream_options;
};

// The client of a stream.
struct Learner {
  std::string owner;
  std::string peer;  // address in gRPC's form, e.g. "ipv4:127.0.0.1:40000"
};

// Attaches a stream of `learner` according to its first request. Calls `done` once: on this thread,
// or on another if another stream must detach first or memory is to be shared.
// Errors: those of ReadAttach, PoolSupervisor::FindForStream, PoolSession::Attach and
// PoolSession::ShareMemory; FAILED_PRECONDITION the pool shares memory and the learner is on
// another machine.
void AttachStream(const PoolSupervisor* supervisor, const Learner& learner,
                  const v1::StepPoolRequest& request, PoolSession::EndStream end_stream,
                  absl::AnyInvocable<void(absl::StatusOr<Attachment>)> done);

// Makes `response` the response to attach.
void FillAttached(const PoolSession& pool, const StreamOptions& stream_options,
                  v1::StepPoolResponse* response);

}  // namespace procgen

#endif  // SERVER_RPC_STEP_ATTACH_H_
