#ifndef TOOLS_CONFORMANCE_REPLAY_H_
#define TOOLS_CONFORMANCE_REPLAY_H_

#include <string>

#include "envcore/trace/trace.h"
#include "tools/conformance/player.h"

namespace procgen {

// Replays `trace` with `player` and compares all that is observed, rewards as bits, pictures if
// `with_pictures` (REQUIRES: the player was made with them, and the trace has digests). Returns the
// first difference (step, environment, field, expected, got), or an empty text.
std::string FirstDifference(const Trace& trace, Player& player, bool with_pictures);

}  // namespace procgen

#endif  // TOOLS_CONFORMANCE_REPLAY_H_
