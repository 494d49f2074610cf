#ifndef TESTS_SERVICE_ROBUSTNESS_BROKEN_CONNECTION_H_
#define TESTS_SERVICE_ROBUSTNESS_BROKEN_CONNECTION_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "procgen/v1/pools.pb.h"
#include "procgen_client/client.h"
#include "procgen_client/remote_pool.h"
#include "tests/service/robustness/fault_proxy.h"

namespace procgen {

// Options of a faulty network in front of `target`, on which some responses arrive between faults.
FaultProxy::Options FaultyNetwork(const std::string& target, uint32_t seed, v1::Encoding encoding);

// Creates a pool of the C++ client at `address`, with rand_seed 5. Null: an error, which has failed
// the test.
std::unique_ptr<procgen_client::RemotePool> CreateRemotePool(
    const std::string& address, const std::vector<std::string>& games, int32_t env_count,
    const procgen_client::RemotePoolOptions& options = {},
    procgen_client::ConnectOptions connect_options = {});

// Steps a pool of twelve environments of two games at `address`, with pipelined requests, while
// `should_continue(response count)`. Returns a hash of all arrays of each response, which depends
// on nothing else. `on_started`: called when the pool exists.
std::vector<size_t> TraceAt(const std::string& address, v1::Encoding encoding,
                            const std::function<bool(size_t)>& should_continue,
                            const std::function<void()>& on_started);

// Steps a pool of the server at `address` through a FaultProxy until it has broken `break_count`
// connections. Then steps an equal pool without a proxy, with raw observations, and expects
// the same trace. So each request was executed once, in order, and its observations were decoded.
void ExpectNothingIsLost(const std::string& address, uint32_t seed, int break_count,
                         v1::Encoding encoding = v1::ENCODING_RAW);

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_BROKEN_CONNECTION_H_
