#ifndef TESTS_SERVICE_SCRIPTED_LEARNER_H_
#define TESTS_SERVICE_SCRIPTED_LEARNER_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "procgen_client/client.h"

namespace procgen {

// What a learner does is drawn from `seed`: steps of all environments and of slices, repeated ones,
// resets, levels to play next, new level samplers, pictures or none, states that are saved, put
// back and cloned. So two learners of one seed see the same, whatever server they have.
struct LearnerScript {
  uint32_t seed = 1;
  int request_count = 1000;
  v1::PoolSpec spec;
  bool with_states = true;  // also saves, restores and clones
};

// A hash of all that each request was answered.
using LearnerTrace = std::vector<uint64_t>;

// Plays a script on a pool that it makes; `before_request` is called before each request with its
// index. Errors: those of the server.
absl::StatusOr<LearnerTrace> PlayScript(const LearnerScript& script, procgen_client::Client* client,
                                        const std::function<void(int index)>& before_request);

// The index of the first request that was answered differently; -1: none.
int FirstDifference(const LearnerTrace& left, const LearnerTrace& right);

}  // namespace procgen

#endif  // TESTS_SERVICE_SCRIPTED_LEARNER_H_
