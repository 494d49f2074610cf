#ifndef SERVER_FLEET_LOG_SHARD_REQUEST_H_
#define SERVER_FLEET_LOG_SHARD_REQUEST_H_

#include <optional>

#include "procgen/v1/step.pb.h"
#include "server/session/backend/request.h"

namespace procgen {

// Converts a request to a message, numbered in the whole pool. `pictures`: arrays of images that
// the request asks for are not empty there. REQUIRES: Accept has filled in its count.
v1::StepPoolRequest RequestMessageOf(const Request& request, const Batch& pictures);

// Returns the part of `request` for the environments of `range`, numbered from the first of them;
// nullopt: none. A reset of other environments only becomes an observe.
std::optional<v1::StepPoolRequest> CutRequest(const v1::StepPoolRequest& request, Part range);

// The intersection; a count of 0: empty.
Part Overlap(Part left, Part right);

// Requests no observations, for a replay.
void DisableObservations(v1::StepPoolRequest* request);

// Converts a level sampler to a message.
v1::LevelSampler LevelSamplerMessageOf(const LevelSampler& level_sampler);

// The slice of a request; for a level sampler, all `env_count` environments.
Part SliceOf(const v1::StepPoolRequest& request, int32_t env_count);

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_SHARD_REQUEST_H_
