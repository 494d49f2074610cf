#ifndef TESTS_SERVICE_ROBUSTNESS_BROKEN_CONNECTION_H_
#define TESTS_SERVICE_ROBUSTNESS_BROKEN_CONNECTION_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "procgen/v1/pools.pb.h"
#include "tests/service/robustness/fault_proxy.h"

namespace procgen {

// How a pool's observations come to its learner.
struct TransportCase {
  v1::Transport transport = v1::TRANSPORT_STREAM;
  v1::Encoding encoding = v1::ENCODING_RAW;
  bool pipe_transport = true;  // past gRPC, where that can be
};

// All that there are.
inline constexpr std::array<TransportCase, 4> kCarriages = {{
    {v1::TRANSPORT_STREAM, v1::ENCODING_RAW},
    {v1::TRANSPORT_STREAM, v1::ENCODING_DELTA_ZSTD},
    {v1::TRANSPORT_SHARED_MEMORY, v1::ENCODING_RAW},
    {v1::TRANSPORT_SHARED_MEMORY, v1::ENCODING_RAW, /*pipe_transport=*/false},
}};

// Twelve environments of two games.
v1::PoolSpec TracedSpec(const TransportCase& carriage = {});

// A bad network to the server at `target`, on which some answers arrive between faults.
FaultProxy::Options BadNetwork(const std::string& target, uint32_t seed,
                               const TransportCase& carriage);

// Steps a new pool of TracedSpec over a connection of its own to `address`, which may be a proxy's,
// with requests sent ahead and answers of several responses, while `goes_on(number of answers)`.
// Returns a hash of each answer: observations, rewards, first, seeds, fingerprints, all of it.
std::vector<size_t> TraceAt(const std::string& address, const std::string& pool,
                            const TransportCase& carriage,
                            const std::function<bool(size_t)>& goes_on,
                            const std::function<void()>& when_attached);

// Steps a pool of the server at `address` through a FaultProxy until it has broken `break_count`
// connections; then an equal pool as often without one, and expects the same trace. So each request
// was carried out once, in its turn, and its observations were decoded. The undisturbed pool is
// always carried as by default.
void ExpectNothingIsLost(const std::string& address, uint32_t seed, int break_count,
                         const TransportCase& carriage = {});

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_BROKEN_CONNECTION_H_
