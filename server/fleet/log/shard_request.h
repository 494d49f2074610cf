#ifndef SERVER_FLEET_LOG_SHARD_REQUEST_H_
#define SERVER_FLEET_LOG_SHARD_REQUEST_H_

#include <optional>

#include "procgen/v1/step.pb.h"
#include "server/session/backend/request.h"

namespace procgen {

// A request as the contract has it, in the numbers of the whole pool. `pictures`: arrays of
// pictures that are asked for are not empty there. REQUIRES: Accept has filled in its count.
v1::StepPoolRequest RequestMessageOf(const Request& request, const Batch& pictures);

// What of `request` concerns the environments of `range`, in numbers that begin with the first of
// them; nullopt: nothing. A reset of others alone is an observe.
std::optional<v1::StepPoolRequest> CutRequest(const v1::StepPoolRequest& request, Part range);

// The environments that both have; a count of 0: none.
Part Overlap(Part left, Part right);

// Has `request` answer no pictures, as is enough where it is only made up for.
void AskForNoPictures(v1::StepPoolRequest* request);

// The same sampler as the contract has it.
v1::LevelSampler LevelSamplerMessageOf(const LevelSampler& level_sampler);

// The slice that a request names; of a level sampler, all: `env_count` environments.
Part SliceOf(const v1::StepPoolRequest& request, int32_t env_count);

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_SHARD_REQUEST_H_
