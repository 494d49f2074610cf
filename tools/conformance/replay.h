#ifndef TOOLS_CONFORMANCE_REPLAY_H_
#define TOOLS_CONFORMANCE_REPLAY_H_

#include <string>

#include "envcore/trace/trace.h"
#include "tools/conformance/player.h"

namespace procgen {

// Replays `trace` with `player` and compares all results. Rewards are compared as bits, and
// observations by digest if `with_pictures`. Returns the first difference (step, environment,
// field, expected, got), or an empty string. REQUIRES for `with_pictures`: the player returns
// observations and the trace has digests.
std::string FirstDifference(const Trace& trace, Player& player, bool with_pictures);

}  // namespace procgen

#endif  // TOOLS_CONFORMANCE_REPLAY_H_
