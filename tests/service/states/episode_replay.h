#ifndef TESTS_SERVICE_STATES_EPISODE_REPLAY_H_
#define TESTS_SERVICE_STATES_EPISODE_REPLAY_H_

#include "procgen/v1/states.pb.h"

namespace procgen {

// Plays an episode that GetEpisode told, in an environment of its own and in this process, and
// checks that it is the same: rewards and sum bit for bit, how it ended, its fingerprint.
// REQUIRES: Episode.incomplete_reason is unset.
void ExpectPlaysTheSame(const v1::Episode& episode);

}  // namespace procgen

#endif  // TESTS_SERVICE_STATES_EPISODE_REPLAY_H_
