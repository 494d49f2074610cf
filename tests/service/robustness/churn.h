#ifndef TESTS_SERVICE_ROBUSTNESS_CHURN_H_
#define TESTS_SERVICE_ROBUSTNESS_CHURN_H_

#include "tests/service/robustness/process_resources.h"

namespace procgen {

// What this process holds, less what its allocator only keeps.
ProcessResources SettledHoldings();

// Makes and drops `rounds` pools on a server in this process, each in one of the bad ways that a
// learner has: cancelled streams, pools deleted under them, connections that are dropped or cut,
// refused requests, streams taken over, answers never read.
// Expects that the server then has no pool and no stream left.
void ChurnPools(int rounds);

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_CHURN_H_
