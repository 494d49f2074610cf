#ifndef SERVER_FLEET_SHARD_BASE_H_
#define SERVER_FLEET_SHARD_BASE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "procgen/v1/pools.pb.h"

namespace procgen {

// From where on a shard can be made anew: its states after a number of the log.
struct ShardBase {
  int64_t number = 0;
  std::vector<std::string> states;                  // of each environment; none: as it was made
  std::shared_ptr<const v1::LevelSampler> sampler;  // in force then; null: none
};

}  // namespace procgen

#endif  // SERVER_FLEET_SHARD_BASE_H_
