#ifndef SERVER_RPC_SERVICES_REMOTE_STATES_H_
#define SERVER_RPC_SERVICES_REMOTE_STATES_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "grpcpp/support/server_callback.h"
#include "server/net/address.h"

namespace procgen {

// Timeout of a whole fetch.
inline constexpr absl::Duration kRemoteStatesTimeout = absl::Seconds(30);
// Limit of the snapshots of one fetch, in bytes. Enough for the environments of the largest server,
// each with a snapshot larger than any observed one.
inline constexpr int64_t kRemoteStatesBytesMax = int64_t{256} << 20;

// Environments of a pool on another server.
struct RemoteEnvironments {
  Address address;
  std::string server;  // the address as given by the caller, for messages
  std::string pool;
  std::vector<int32_t> environments;  // each at most once
};

using RemoteStatesDone = absl::AnyInvocable<void(absl::StatusOr<std::vector<std::string>>)>;

// Fetches snapshots of environments from another server, page by page, as its client. Returns
// immediately; `done` is called once, on a gRPC thread, with the snapshots in the requested order.
// `caller` must not finish before that: its deadline and cancellation are propagated. Its token is
// not sent, because a process that impersonates the other server could use it here.
// Errors, all with the server's address: UNAVAILABLE it cannot be reached, exceeds
// kRemoteStatesTimeout or returns no states (always the same message; the log has the reason);
// RESOURCE_EXHAUSTED more than kRemoteStatesBytesMax; INTERNAL it returned other environments than
// requested; those of SaveStates.
void FetchRemoteStates(const grpc::CallbackServerContext& caller, RemoteEnvironments source,
                       RemoteStatesDone done);

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_REMOTE_STATES_H_
