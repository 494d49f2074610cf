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

// Answers a request of the properties extension. README.md lists the properties: those of the
// server, and those of the joined world if `session` is not null. `request` and `response` must
// stay valid until `done`, which is called once, on any thread. Errors: NOT_FOUND no such property;
// PERMISSION_DENIED it cannot be read, written or listed; INVALID_ARGUMENT wrong type, shape or
// value; those of Pool's SaveStates and RestoreStates.
void AnswerPropertyRequest(const PoolSupervisor& supervisor, absl::string_view owner,
                           WorldSession* session, const dm_properties::PropertyRequest& request,
                           dm_properties::PropertyResponse* response, PoolSession::Done done);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_PROPERTIES_H_
