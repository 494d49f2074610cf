#ifndef SERVER_RPC_SERVICES_EPISODE_CALL_H_
#define SERVER_RPC_SERVICES_EPISODE_CALL_H_

#include <string>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "procgen/v1/episodes.pb.h"
#include "server/pool/pool_supervisor.h"

namespace procgen {

// Fills `response` with an episode of a pool of `owner`, read between two requests of its stream,
// and calls `done` once, on any thread. The pointers and references must stay valid until then.
// Errors: those of PoolService.GetEpisode.
void FetchEpisode(PoolSupervisor* supervisor, const std::string& owner,
                  const v1::GetEpisodeRequest& request, v1::Episode* response,
                  absl::AnyInvocable<void(absl::Status)> done);

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_EPISODE_CALL_H_
