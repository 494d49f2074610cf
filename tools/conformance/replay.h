#ifndef TOOLS_CONFORMANCE_REPLAY_H_
#define TOOLS_CONFORMANCE_REPLAY_H_

#include <string>

#include "envcore/pool/pool.h"
#include "envcore/trace/trace.h"
#include "procgen_client/pool.h"

namespace procgen {

// The pool of a trace, with the built-in art.
PoolOptions PoolOptionsOf(const Trace& trace);

// Replays `trace` with `pool` and compares all results. Rewards are compared as bits, and
// observations by digest if `with_pictures`. Returns the first difference (step, environment,
// field, expected, got), or an empty string. REQUIRES for `with_pictures`: the trace has digests.
std::string FirstDifference(const Trace& trace, procgen_client::Pool& pool, bool with_pictures);

}  // namespace procgen

#endif  // TOOLS_CONFORMANCE_REPLAY_H_
