#ifndef SERVER_RPC_STEP_RESUME_REPLAY_H_
#define SERVER_RPC_STEP_RESUME_REPLAY_H_

#include <memory>
#include <string>
#include <vector>

#include "server/session/pool/pool_session.h"

namespace procgen {

// Executes requests that an earlier process of this server accepted, which restores the pool's
// state, and keeps their answers for learners that attach again. `requests`: serialised, in order.
// The replay takes the pool's first turn and then runs in the background.
//
// After a permanent error (DATA_LOSS, FAILED_PRECONDITION, INTERNAL and the like) the pool fails
// with that error. After any other error the request is retried with exponential backoff. The
// replay keeps the turn until it succeeds, the pool is closed or the server drains.
//
// Kept answers have small responses and, with an encoding, only key frames, so that they can be
// sent on any stream.
void StartResumeReplay(std::shared_ptr<PoolSession> pool, std::vector<std::string> requests,
                       int64_t response_bytes_max);

}  // namespace procgen

#endif  // SERVER_RPC_STEP_RESUME_REPLAY_H_
