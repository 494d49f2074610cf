#ifndef TESTS_SERVICE_ROBUSTNESS_CHURN_H_
#define TESTS_SERVICE_ROBUSTNESS_CHURN_H_

#include <string>

#include "tests/service/robustness/process_resources.h"

namespace procgen {

// Memory and files in use by this process, without free memory that the allocator keeps.
ProcessResources ResourcesInUse();

// Creates a pool on the server at `address` and drops it in one of several abrupt ways, chosen by
// `way`: cancelled streams, lost connections, invalid requests, unread responses.
void DropPool(const std::string& address, size_t way);

// Drops `rounds` pools of a server in this process, in all ways. Expects that the server then has
// no pools.
void ChurnPools(size_t rounds);

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_CHURN_H_
