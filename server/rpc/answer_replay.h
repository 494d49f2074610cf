#ifndef SERVER_RPC_ANSWER_REPLAY_H_
#define SERVER_RPC_ANSWER_REPLAY_H_

#include <memory>
#include <string>
#include <vector>

#include "server/session/pool_session.h"

namespace procgen {

// Carries out requests that an earlier process of this server had accepted, and keeps their answers
// for learners that attach again and ask for them; begins at once, takes the first turn, and goes
// on by itself. `requests`: serialised, in order. Then the pool is where that process had it.
//
// Answers are told in small parts, and encoded observations each without their past, so that they
// suit whoever attaches.
void ReplayAnswers(std::shared_ptr<PoolSession> pool, std::vector<std::string> requests,
                   int64_t response_bytes_max);

}  // namespace procgen

#endif  // SERVER_RPC_ANSWER_REPLAY_H_
