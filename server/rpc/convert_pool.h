#ifndef SERVER_RPC_CONVERT_POOL_H_
#define SERVER_RPC_CONVERT_POOL_H_

#include "absl/status/statusor.h"
#include "envcore/pool/pool.h"
#include "procgen/v1/pools.pb.h"
#include "server/session/pool_session.h"

namespace procgen {

// What a spec asks of the engine; a rand_seed that is absent is drawn.
// Errors: INVALID_ARGUMENT a value that its field does not offer; UNIMPLEMENTED one that this
// server does not offer yet (the message says what is offered).
absl::StatusOr<PoolOptions> PoolOptionsOf(const v1::PoolSpec& spec);

// The pool as a resource, its spec with every default filled in.
v1::Pool PoolMessageOf(const PoolSession& session);

// The contract's name for a mode.
v1::DistributionMode DistributionModeMessageOf(DistributionMode mode);

}  // namespace procgen

#endif  // SERVER_RPC_CONVERT_POOL_H_
