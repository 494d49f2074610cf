#ifndef SERVER_SESSION_ROW_MEMORY_H_
#define SERVER_SESSION_ROW_MEMORY_H_

#include <cstdint>
#include <vector>

#include "envcore/pool/pool.h"

namespace procgen {

// Memory for what a pool's session reads of a batch and its learner has not asked for; kept from
// part to part. Threads: one at a time.
class RowMemory {
 public:
  // `batch`, of `count` environments, with all of its arrays but the pictures. Valid until the next
  // call.
  Batch LendTo(Batch batch, int32_t count);

 private:
  std::vector<float> rewards_;
  std::vector<uint8_t> first_;
  std::vector<uint8_t> terminated_;
  std::vector<uint8_t> truncated_;
  std::vector<int32_t> level_seeds_;
  std::vector<int32_t> prev_level_seeds_;
  std::vector<uint8_t> prev_level_complete_;
  std::vector<float> episode_returns_;
  std::vector<int32_t> episode_lengths_;
  std::vector<uint64_t> fingerprints_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_ROW_MEMORY_H_
