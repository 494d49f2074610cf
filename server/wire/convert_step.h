#ifndef SERVER_WIRE_CONVERT_STEP_H_
#define SERVER_WIRE_CONVERT_STEP_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "procgen/v1/step.pb.h"
#include "server/session/backend/observation_coding.h"
#include "server/session/backend/request.h"
#include "server/session/quota/quotas.h"

namespace procgen {

// A request of a stream with the memory that it refers to. Kept and filled again, unless it is
// large.
struct StreamRequest {
  v1::StepPoolRequest message;
  size_t message_bytes = 0;         // on the wire
  Quotas::Reservation reservation;  // of a large one
  std::vector<NextLevel> next_levels;
  std::vector<Reset> resets;
  Request request;  // refers to the above
};

// Fills in `next_levels`, `resets` and, but for its `arrival_time` and `chunk_rows_max`, `request`
// from `message`; what depends on the pool is not checked. Errors: INVALID_ARGUMENT no request, or
// one that must not be here; UNIMPLEMENTED.
absl::Status ReadStreamRequest(StreamRequest* request);

// How many environments fit one response of at most `response_bytes_max` bytes, of a pool whose
// observations are sent as `coding` says, however badly they can be compressed. At least 1. Errors:
// RESOURCE_EXHAUSTED not even one; `limit` is what to call the limit.
absl::StatusOr<int32_t> ResponseRowsMax(absl::string_view limit, const Request& request,
                                        const ObservationCoding& coding,
                                        int64_t response_bytes_max);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_STEP_H_
