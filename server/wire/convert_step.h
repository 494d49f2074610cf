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

// A request of a stream with the memory that it refers to. Reused for later requests, unless it is
// large.
struct StreamRequest {
  v1::StepPoolRequest message;
  size_t message_bytes = 0;         // serialised size
  Quotas::Reservation reservation;  // of a large request
  std::vector<NextLevel> next_levels;
  std::vector<Reset> resets;
  std::vector<Annotation> annotations;
  Request request;  // refers to the members above
};

// Sets `next_levels`, `resets`, `annotations` and `request` (except `arrival_time` and
// `chunk_rows_max`) from `message`. Does not check what depends on the pool. Errors:
// INVALID_ARGUMENT the message is empty, an attach or invalid; UNIMPLEMENTED.
absl::Status ReadStreamRequest(StreamRequest* request);

// Returns the number of environments that fit in one response of `response_bytes_max` bytes, with
// observations in the form of `coding` and of any compressibility. At least 1.
// Errors: RESOURCE_EXHAUSTED not one fits. `limit`: name of the limit in the error.
absl::StatusOr<int32_t> ResponseRowsMax(absl::string_view limit, const Request& request,
                                        const ObservationCoding& coding,
                                        int64_t response_bytes_max);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_STEP_H_
