#ifndef TESTS_SERVICE_BROKEN_CONNECTION_H_
#define TESTS_SERVICE_BROKEN_CONNECTION_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "procgen/v1/pools.pb.h"

namespace procgen {

// Twelve environments of two games.
v1::PoolSpec TracedSpec(v1::Transport transport = v1::TRANSPORT_STREAM,
                        v1::Encoding encoding = v1::ENCODING_RAW);

// Steps a new pool of TracedSpec over a connection of its own to `address`, which may be a proxy's,
// with requests sent ahead and answers of several responses, while `goes_on(number of answers)`.
// Returns a hash of each answer: observations, rewards, first, seeds, fingerprints, all of it.
std::vector<size_t> TraceAt(const std::string& address, const std::string& pool,
                            const std::function<bool(size_t)>& goes_on,
                            const std::function<void()>& when_attached);

// Steps a pool of the server at `address` through a FaultProxy until it has broken `break_count`
// connections; then an equal pool as often without one, and expects the same trace. So each request
// was carried out once, in its turn, and its observations were decoded. The undisturbed pool is
// always one of TRANSPORT_STREAM and ENCODING_RAW.
void ExpectNothingIsLost(const std::string& address, uint32_t seed, int break_count,
                         v1::Transport transport = v1::TRANSPORT_STREAM,
                         v1::Encoding encoding = v1::ENCODING_RAW);

}  // namespace procgen

#endif  // TESTS_SERVICE_BROKEN_CONNECTION_H_
