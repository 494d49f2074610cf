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

// The transport of a pool's observations.
struct TransportCase {
  v1::Transport transport = v1::TRANSPORT_STREAM;
  v1::Encoding encoding = v1::ENCODING_RAW;
  bool pipe_transport = true;  // if shared memory is used
};

// All transports.
inline constexpr std::array<TransportCase, 4> kTransportCases = {{
    {v1::TRANSPORT_STREAM, v1::ENCODING_RAW},
    {v1::TRANSPORT_STREAM, v1::ENCODING_DELTA_ZSTD},
    {v1::TRANSPORT_SHARED_MEMORY, v1::ENCODING_RAW},
    {v1::TRANSPORT_SHARED_MEMORY, v1::ENCODING_RAW, /*pipe_transport=*/false},
}};

// Twelve environments of two games.
v1::PoolSpec TracedSpec(const TransportCase& transport_case = {});

// Options of a faulty network in front of `target`, on which some responses arrive between faults.
FaultProxy::Options FaultyNetwork(const std::string& target, uint32_t seed,
                                  const TransportCase& transport_case);

// Steps `pool` over a new connection to `address`, with pipelined requests and responses of several
// messages, while `should_continue(response count)`. Returns a hash of all arrays of each response.
std::vector<size_t> TraceAt(const std::string& address, const std::string& pool,
                            const TransportCase& transport_case,
                            const std::function<bool(size_t)>& should_continue,
                            const std::function<void()>& on_attached);

// Steps a pool of the server at `address` through a FaultProxy until it has broken `break_count`
// connections. Then steps an equal pool without a proxy, with the default transport, and expects
// the same trace. So each request was executed once, in order, and its observations were decoded.
void ExpectNothingIsLost(const std::string& address, uint32_t seed, int break_count,
                         const TransportCase& transport_case = {});

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_BROKEN_CONNECTION_H_
