#ifndef SERVER_FLEET_NODES_NODE_ANSWERS_H_
#define SERVER_FLEET_NODES_NODE_ANSWERS_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/pools.pb.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/states.pb.h"
#include "procgen/v1/step.pb.h"
#include "procgen_client/batch.h"
#include "procgen_client/step_stream.h"
#include "server/session/backend/request.h"

namespace procgen {

// Whether another node might succeed after this error. False: any node would return it.
bool IsNodeError(const absl::Status& status);

// Validation of nodes' answers before they are used: a node may be faulty, hostile or of another
// version. All return DATA_LOSS with the answered and the expected value.

// Checks the limits in a node's catalog.
absl::Status CheckNodeLimits(const v1::Limits& limits);
// Checks the pool that a node created from `spec` as `pool_id`.
absl::Status CheckNodePool(const v1::Pool& pool, const v1::PoolSpec& spec,
                           const std::string& pool_id);
// Checks a stream attached to a pool of `env_count` environments, for so many requests in flight.
absl::Status CheckNodeStream(const procgen_client::StepStream& stream, int32_t env_count,
                             int32_t requests_in_flight_max);

// The rows that a step, reset or observe asks for.
struct RequestedRows {
  Part slice;
  bool observations = false;
  bool final_observations = false;
};
RequestedRows AskedRowsOf(const v1::StepPoolRequest& request);
// Checks the answer to a request for `asked`: exactly its rows, and the size of each array.
// `observation_bytes`: of one environment.
absl::Status CheckNodeBatch(const procgen_client::Batch& batch, const RequestedRows& asked,
                            size_t observation_bytes);

// Returns the snapshots of `environments`, in this order; of `env_count` environments if the list
// is empty.
absl::StatusOr<std::vector<std::string>> TakeNodeStates(std::vector<v1::State> states,
                                                        absl::Span<const int32_t> environments,
                                                        int32_t env_count);
// Checks that there is one frame of `bytes` bytes.
absl::Status CheckNodeFrame(const v1::RenderEnvironmentsResponse& response, size_t bytes);

}  // namespace procgen

#endif  // SERVER_FLEET_NODES_NODE_ANSWERS_H_
