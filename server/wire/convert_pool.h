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
#include "server/session/pool/pool_session.h"
#include "server/session/quota/limits.h"

namespace procgen {

// What a spec asks of the engine; a rand_seed that is absent is drawn.
// Errors: INVALID_ARGUMENT a value that its field does not offer.
absl::StatusOr<PoolOptions> PoolOptionsOf(const v1::PoolSpec& spec);

// A spec that asks for the same, every default filled in; without the level sampler, whose lists
// may be long.
v1::PoolSpec PoolSpecMessageOf(const PoolOptions& options);

// The same as a message, every field filled in.
v1::EnvironmentOptions EnvironmentOptionsMessageOf(const EnvironmentOptions& options);

// Whether a pool of `spec` shares memory with its learners, on a server that offers it or does not.
// Errors: INVALID_ARGUMENT no such transport; UNIMPLEMENTED it is not offered. Whether it goes with
// the encoding, CompressionOf checks.
absl::StatusOr<bool> SharesMemory(const v1::PoolSpec& spec, bool offered);

// The lease of a pool; infinite for a duration of 0, which means none. `field`: its name in errors.
// Errors: INVALID_ARGUMENT an invalid or too short duration; RESOURCE_EXHAUSTED longer than the
// limit.
absl::StatusOr<absl::Duration> LeaseDurationOf(absl::string_view field,
                                               const google::protobuf::Duration& message,
                                               const Limits& limits);

// `field` is what to call it. Errors: INVALID_ARGUMENT as LevelSampler::Create.
absl::StatusOr<std::shared_ptr<const LevelSampler>> LevelSamplerOf(absl::string_view field,
                                                                   const v1::LevelSampler& message);

// The same, counted among the buffers of `owner` until the last pool lets go of it. Errors:
// RESOURCE_EXHAUSTED.
absl::StatusOr<std::shared_ptr<const LevelSampler>> HoldSampler(
    absl::string_view owner, std::shared_ptr<const LevelSampler> sampler, Quotas* quotas);

google::protobuf::Duration DurationMessageOf(absl::Duration duration);
// The inverse of LeaseDurationOf: 0 for an infinite lease.
google::protobuf::Duration LeaseDurationMessageOf(absl::Duration lease_duration);
void FillTimestamp(absl::Time time, google::protobuf::Timestamp* message);

// The pool as a resource, its spec with every default filled in, but without the level sampler,
// whose lists may be long.
v1::Pool PoolMessageOf(const PoolSession& session);

// The contract's name for a mode.
v1::DistributionMode DistributionModeMessageOf(DistributionMode mode);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_POOL_H_
