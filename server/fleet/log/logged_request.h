#ifndef SERVER_FLEET_LOG_LOGGED_REQUEST_H_
#define SERVER_FLEET_LOG_LOGGED_REQUEST_H_

#include <vector>

#include "procgen/v1/states.pb.h"
#include "procgen/v1/step.pb.h"

namespace procgen {

// Something that was asked of a pool and may have changed it, in the numbers of the whole pool: a
// request of its stream, or states that were put into it.
struct LoggedRequest {
  v1::StepPoolRequest request;    // of none of the kinds: states
  std::vector<v1::State> states;  // none: a request
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_LOGGED_REQUEST_H_
