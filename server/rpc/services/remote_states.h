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

// How long another server has to answer with all that is asked of it.
inline constexpr absl::Duration kRemoteStatesTimeout = absl::Seconds(30);
// Bytes of the snapshots that are fetched at once: as many as the largest server has environments,
// each larger than any was seen to be.
inline constexpr int64_t kRemoteStatesBytesMax = int64_t{256} << 20;

// Which environments of which pool of which server.
struct RemoteEnvironments {
  Address address;
  std::string server;  // as the caller calls it
  std::string pool;
  std::vector<int32_t> environments;  // each at most once
};

using RemoteStatesDone = absl::AnyInvocable<void(absl::StatusOr<std::vector<std::string>>)>;

// Fetches the snapshots of environments from another server, page by page, as a client of it, and
// returns at once; `done` is called once, on a thread of gRPC, with the snapshots in the order
// asked for. On behalf of `caller`, which must not be finished before then: its deadline and
// cancellation are passed on. Its token is not: it is meant for this server, and whoever listens in
// the other's place could use it here.
// Errors, all of which name the server: UNAVAILABLE it cannot be reached, does not answer in
// kRemoteStatesTimeout, or gives no states (one message, whatever the reason: the log has it);
// RESOURCE_EXHAUSTED more than kRemoteStatesBytesMax; INTERNAL it answers something else than was
// asked for; those of SaveStates, of a server that was reached.
void FetchRemoteStates(const grpc::CallbackServerContext& caller, RemoteEnvironments source,
                       RemoteStatesDone done);

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_REMOTE_STATES_H_
