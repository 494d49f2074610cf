#ifndef SERVER_RPC_ATTACH_H_
#define SERVER_RPC_ATTACH_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "procgen/v1/step.pb.h"
#include "server/session/limits.h"
#include "server/session/pool_session.h"

namespace procgen {

// What a stream gets that attaches.
struct StreamTerms {
  AttachOptions options;
  int64_t response_bytes_max = 0;
};

// What the first request of a stream asks for. Errors: INVALID_ARGUMENT it is no attach, or asks
// for what makes no sense; RESOURCE_EXHAUSTED for more than a limit.
absl::StatusOr<StreamTerms> ReadAttach(const v1::StepPoolRequest& request, const Limits& limits);

// The answer to attach.
void FillAttached(const PoolSession& pool, const StreamTerms& terms,
                  v1::StepPoolResponse* response);

}  // namespace procgen

#endif  // SERVER_RPC_ATTACH_H_
