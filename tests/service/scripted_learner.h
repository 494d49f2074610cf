#ifndef TESTS_SERVICE_SCRIPTED_LEARNER_H_
#define TESTS_SERVICE_SCRIPTED_LEARNER_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "procgen_client/client.h"

namespace procgen {

// The requests of a learner, drawn from `seed`: steps of all environments and of slices, action
// repeats, resets, next levels, new level samplers, observations or none, and states that are
// saved, restored and cloned. Two learners with one seed receive equal responses from any server.
struct LearnerScript {
  uint32_t seed = 1;
  int request_count = 1000;
  v1::PoolSpec spec;
  bool with_states = true;  // also saves, restores and clones
};

// One hash per request, of its response.
using LearnerTrace = std::vector<uint64_t>;

// Creates a pool and executes the script on it. Calls `before_request` with the index of each
// request before it is sent. Errors: those of the server.
absl::StatusOr<LearnerTrace> PlayScript(const LearnerScript& script, procgen_client::Client* client,
                                        const std::function<void(int index)>& before_request);

// The index of the first request with different responses; -1 if there is none.
int FirstDifference(const LearnerTrace& left, const LearnerTrace& right);

}  // namespace procgen

#endif  // TESTS_SERVICE_SCRIPTED_LEARNER_H_
