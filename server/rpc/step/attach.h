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

// What a stream gets that attaches.
struct StreamOptions {
  AttachOptions attach;
  int64_t response_bytes_max = 0;
};

// What the first request of a stream asks for. Errors: INVALID_ARGUMENT it is no attach, or asks
// for what makes no sense; RESOURCE_EXHAUSTED for more than a limit.
absl::StatusOr<StreamOptions> ReadAttach(const v1::StepPoolRequest& request, const Limits& limits);

// A pool that a stream has.
struct Attachment {
  std::shared_ptr<PoolSession> pool;
  StreamOptions stream_options;
};

// Whose stream it is, and from where.
struct Learner {
  std::string owner;
  std::string peer;  // as gRPC tells it, e.g. "ipv4:127.0.0.1:40000"
};

// Attaches a stream of `learner` as its first request asks for, and calls `done` once, on this
// thread or another: where another stream must let go first, or memory is to be shared. Errors:
// those of ReadAttach, PoolSupervisor::FindForStream, PoolSession::Attach and
// PoolSession::ShareMemory; FAILED_PRECONDITION the pool shares memory and the learner is on
// another machine.
void AttachStream(const PoolSupervisor* supervisor, const Learner& learner,
                  const v1::StepPoolRequest& request, PoolSession::EndStream end_stream,
                  absl::AnyInvocable<void(absl::StatusOr<Attachment>)> done);

// The answer to attach.
void FillAttached(const PoolSession& pool, const StreamOptions& stream_options,
                  v1::StepPoolResponse* response);

}  // namespace procgen

#endif  // SERVER_RPC_STEP_ATTACH_H_
