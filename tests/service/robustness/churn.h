#ifndef TESTS_SERVICE_ROBUSTNESS_CHURN_H_
#define TESTS_SERVICE_ROBUSTNESS_CHURN_H_

#include "tests/service/robustness/process_resources.h"

namespace procgen {

// Memory and files in use by this process, without free memory that the allocator keeps.
ProcessResources ResourcesInUse();

// Creates and drops `rounds` pools on a server in this process, each in one abrupt way: cancelled
// streams, deleted pools, lost connections, invalid requests, takeovers, unread responses. Expects
// that the server then has no pools and streams.
void ChurnPools(int rounds);

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_CHURN_H_
