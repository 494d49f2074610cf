#ifndef SERVER_RPC_ATTACH_H_
#define SERVER_RPC_ATTACH_H_

#include <cstdint>
#include <memory>

#include "absl/functional/any_invocable.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "procgen/v1/step.pb.h"
#include "server/session/limits.h"
#include "server/session/pool_session.h"
#include "server/session/sessions.h"

namespace procgen {

// What a stream gets that attaches.
struct StreamTerms {
  AttachOptions options;
  int64_t response_bytes_max = 0;
};

// What the first request of a stream asks for. Errors: INVALID_ARGUMENT it is no attach, or asks
// for what makes no sense; RESOURCE_EXHAUSTED for more than a limit.
absl::StatusOr<StreamTerms> ReadAttach(const v1::StepPoolRequest& request, const Limits& limits);

// A pool that a stream has.
struct Attachment {
  std::shared_ptr<PoolSession> pool;
  StreamTerms terms;
};

// Attaches a stream of `owner` as its first request asks for, and calls `done` once, on this thread
// or, where another stream must let go first, on that one's. Errors: those of ReadAttach,
// Sessions::FindForStream and PoolSession::Attach.
void AttachStream(const Sessions* sessions, absl::string_view owner,
                  const v1::StepPoolRequest& request, PoolSession::EndStream end_stream,
                  absl::AnyInvocable<void(absl::StatusOr<Attachment>)> done);

// The answer to attach.
void FillAttached(const PoolSession& pool, const StreamTerms& terms,
                  v1::StepPoolResponse* response);

}  // namespace procgen

#endif  // SERVER_RPC_ATTACH_H_
