#ifndef SERVER_RPC_GRPC_GRPC_DEADLINE_H_
#define SERVER_RPC_GRPC_GRPC_DEADLINE_H_

#include "absl/time/time.h"
#include "grpc/support/time.h"

namespace procgen {

// Returns the time `timeout` from now on the steady clock.
inline gpr_timespec GrpcDeadlineIn(absl::Duration timeout) {
  return gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC),
                      gpr_time_from_nanos(absl::ToInt64Nanoseconds(timeout), GPR_TIMESPAN));
}

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_GRPC_DEADLINE_H_
