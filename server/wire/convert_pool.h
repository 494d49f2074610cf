#ifndef SERVER_WIRE_CONVERT_POOL_H_
#define SERVER_WIRE_CONVERT_POOL_H_

#include <memory>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "envcore/pool/pool.h"
#include "google/protobuf/duration.pb.h"
#include "google/protobuf/timestamp.pb.h"
#include "procgen/v1/pools.pb.h"
#include "server/pool/pool_session.h"
#include "server/pool/quota/quotas.h"
#include "server/pool/session_options.h"

namespace procgen {

// Converts a spec to the engine's options. Draws an absent rand_seed.
// Errors: INVALID_ARGUMENT a value is not allowed for its field.
absl::StatusOr<PoolOptions> PoolOptionsOf(const v1::PoolSpec& spec);

// Converts the fields of a spec that are not the engine's. Errors: INVALID_ARGUMENT.
absl::StatusOr<SessionOptions> SessionOptionsOf(const v1::PoolSpec& spec);

// Converts options to a spec with every default filled in. Omits the level sampler, whose lists may
// be long.
v1::PoolSpec PoolSpecMessageOf(const PoolOptions& options);

// Converts options to a message with every field set.
v1::EnvironmentOptions EnvironmentOptionsMessageOf(const EnvironmentOptions& options);

// Converts a level sampler. `field`: its name in errors. Errors: those of LevelSampler::Create.
absl::StatusOr<std::shared_ptr<const LevelSampler>> LevelSamplerOf(absl::string_view field,
                                                                   const v1::LevelSampler& message);

// Returns `sampler` with its size reserved in the buffer quota of `owner`, until the last reference
// is released. Errors: RESOURCE_EXHAUSTED.
absl::StatusOr<std::shared_ptr<const LevelSampler>> HoldSampler(
    absl::string_view owner, std::shared_ptr<const LevelSampler> sampler, Quotas* quotas);

google::protobuf::Duration DurationMessageOf(absl::Duration duration);
void FillTimestamp(absl::Time time, google::protobuf::Timestamp* message);

// Returns the pool's resource, with the spec of PoolSpecMessageOf.
v1::Pool PoolMessageOf(const PoolSession& session);

// Converts a mode to the API's enum.
v1::DistributionMode DistributionModeMessageOf(DistributionMode mode);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_POOL_H_
