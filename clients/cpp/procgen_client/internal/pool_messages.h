#ifndef PROCGEN_CLIENT_INTERNAL_POOL_MESSAGES_H_
#define PROCGEN_CLIENT_INTERNAL_POOL_MESSAGES_H_

#include "absl/types/span.h"
#include "envcore/environment/level_sampler.h"
#include "envcore/pool/pool.h"
#include "procgen/v1/pools.pb.h"
#include "procgen/v1/run.pb.h"
#include "procgen_client/pool.h"

// The engine's options, requests and batches as messages, and back.
namespace procgen_client {

// Without art: a server draws with its own.
procgen::v1::PoolSpec SpecOf(const procgen::PoolOptions& options, procgen::v1::Encoding encoding);
procgen::v1::LevelSampler MessageOf(const procgen::LevelSampler& level_sampler);

// Which observations a request asks for.
struct WantedObservations {
  bool current = false;
  bool final = false;  // of episodes that end in the step
};
procgen::v1::RunPoolRequest RequestOf(const procgen::StepInput& input,
                                      absl::Span<const Annotation> annotations,
                                      WantedObservations wanted);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_POOL_MESSAGES_H_
