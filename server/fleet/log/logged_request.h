#ifndef SERVER_FLEET_LOG_LOGGED_REQUEST_H_
#define SERVER_FLEET_LOG_LOGGED_REQUEST_H_

#include <vector>

#include "procgen/v1/states.pb.h"
#include "procgen/v1/step.pb.h"

namespace procgen {

// A log entry: a request of the pool's stream, or restored states. Environments are numbered in the
// whole pool.
struct LoggedRequest {
  v1::StepPoolRequest request;    // no kind is set: `states` is used
  std::vector<v1::State> states;  // empty: `request` is used
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_LOGGED_REQUEST_H_
