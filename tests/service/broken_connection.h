#ifndef TESTS_SERVICE_BROKEN_CONNECTION_H_
#define TESTS_SERVICE_BROKEN_CONNECTION_H_

#include <cstdint>
#include <string>

namespace procgen {

// Steps a pool of the server at `address` through a FaultProxy until it has broken `break_count`
// connections, with requests sent ahead and answers of several responses; then steps an equal pool
// as often without one, and expects the same of each answer: observations, rewards, first, seeds,
// fingerprints, all of it. Also that each environment was stepped once for each request.
void ExpectNothingIsLost(const std::string& address, uint32_t seed, int break_count);

}  // namespace procgen

#endif  // TESTS_SERVICE_BROKEN_CONNECTION_H_
