#ifndef SERVER_FLEET_LOG_SHARD_CHECKPOINT_H_
#define SERVER_FLEET_LOG_SHARD_CHECKPOINT_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "procgen/v1/pools.pb.h"
#include "server/fleet/log/request_log.h"
#include "server/session/backend/request.h"

namespace procgen {

// The states of a shard at a position of the log, from which it can restart.
struct ShardCheckpoint {
  int64_t number = 0;
  std::vector<std::string> states;                  // of each environment; empty: as created
  std::shared_ptr<const v1::LevelSampler> sampler;  // in force at that position; null: none
};

// A saved checkpoint that may not be usable yet. It is usable once observations can be drawn from
// it, also those of requests that may have to be answered again.
struct PendingCheckpoint {
  std::shared_ptr<const ShardCheckpoint> checkpoint;
  int64_t drawable_number = 0;  // from this request on; 0: not yet

  // `number`: of the current request. `answers_kept`: how many requests may have to be answered
  // again.
  bool IsUsable(const RequestLog& log, Part range, int64_t number, int64_t answers_kept) {
    if (drawable_number == 0 && log.CanDrawFrom(range, checkpoint->number)) {
      drawable_number = log.end();
    }
    return drawable_number > 0 && number >= drawable_number + answers_kept &&
           number > checkpoint->number + answers_kept;
  }
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_SHARD_CHECKPOINT_H_
