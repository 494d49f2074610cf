#ifndef SERVER_DM_ENV_RPC_PROPERTIES_H_
#define SERVER_DM_ENV_RPC_PROPERTIES_H_

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "dm_env_rpc/v1/extensions/properties.pb.h"
#include "server/dm_env_rpc/world_session.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

namespace dm_properties = ::dm_env_rpc::v1::extensions::properties;

// Answers a request about properties, of the server and, if `play` is not null, of the world that
// is played; README.md lists them. `request` and `response` must stay valid until `done`, which is
// called once, on any thread. Errors: NOT_FOUND no such property; PERMISSION_DENIED it cannot be
// read, written or listed; INVALID_ARGUMENT a value that it does not take; those of Pool's
// SaveStates and RestoreStates.
void AnswerPropertyRequest(const PoolSupervisor& supervisor, absl::string_view owner,
                           WorldSession* play, const dm_properties::PropertyRequest& request,
                           dm_properties::PropertyResponse* response, PoolSession::Done done);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_PROPERTIES_H_
