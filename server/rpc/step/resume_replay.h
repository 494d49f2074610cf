#ifndef SERVER_RPC_STEP_RESUME_REPLAY_H_
#define SERVER_RPC_STEP_RESUME_REPLAY_H_

#include <memory>
#include <string>
#include <vector>

#include "server/session/pool/pool_session.h"

namespace procgen {

// Carries out requests that an earlier process of this server had accepted, and keeps their answers
// for learners that attach again and ask for them; begins at once, takes the first turn, and goes
// on by itself. `requests`: serialised, in order. Then the pool is where that process had it.
//
// Where a request fails as it would again (DATA_LOSS, FAILED_PRECONDITION, INTERNAL and the like),
// the pool fails with that error. After any other error the request is repeated, later each time,
// and the turn stays with it, until the pool is closed or the server drains.
//
// Answers are told in small parts, and encoded observations each without their past, so that they
// suit whoever attaches.
void StartResumeReplay(std::shared_ptr<PoolSession> pool, std::vector<std::string> requests,
                       int64_t response_bytes_max);

}  // namespace procgen

#endif  // SERVER_RPC_STEP_RESUME_REPLAY_H_
