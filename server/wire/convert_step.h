#ifndef SERVER_WIRE_CONVERT_STEP_H_
#define SERVER_WIRE_CONVERT_STEP_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "procgen/v1/run.pb.h"
#include "server/encoding/encoding.h"
#include "server/pool/request.h"

namespace procgen {

// A request with the memory that it refers to.
struct RequestMemory {
  std::vector<NextLevel> next_levels;
  std::vector<Reset> resets;
  std::vector<Annotation> annotations;
  Request request;  // refers to the members above

  // Empties all.
  void Clear();
};

// Converts a step, reset, observe or level sampler to `memory`, which refers to it. What depends on
// the pool is not checked. Errors: INVALID_ARGUMENT, also another kind of request.
absl::Status ReadRequest(const v1::RunPoolRequest& message, RequestMemory* memory);

// Checks that the response fits in `response_bytes_max` bytes. `observation_bytes`: of one as
// drawn. Errors: RESOURCE_EXHAUSTED.
absl::Status CheckResponseFits(const Request& request, Encoding encoding, int64_t observation_bytes,
                               int64_t response_bytes_max);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_STEP_H_
