#ifndef TESTS_SERVICE_STATES_EPISODE_REPLAY_H_
#define TESTS_SERVICE_STATES_EPISODE_REPLAY_H_

#include "procgen/v1/episodes.pb.h"

namespace procgen {

// Replays an episode of GetEpisode in a new environment in this process. Expects equal rewards and
// return, bit for bit, the same outcome and fingerprint. REQUIRES: Episode.incomplete_reason is
// unset.
void ExpectReplayIsEqual(const v1::Episode& episode);

}  // namespace procgen

#endif  // TESTS_SERVICE_STATES_EPISODE_REPLAY_H_
