#ifndef SERVER_FLEET_LOG_POOL_LOG_H_
#define SERVER_FLEET_LOG_POOL_LOG_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "procgen/v1/pools.pb.h"
#include "server/fleet/log/journal.h"
#include "server/fleet/log/logged_request.h"
#include "server/fleet/log/request_log.h"
#include "server/fleet/log/shard_checkpoint.h"
#include "server/metrics/metrics.h"

namespace procgen {

// The request log of a pool in memory, and its journal on disk if the pool is kept.
// Threads: any method from any thread. Keep or Resume come before other methods, or while no
// request runs.
class PoolLog {
 public:
  // `label`: the pool's name in errors. `bytes_max`: maximum memory of the log.
  PoolLog(int32_t env_count, int32_t frame_stack, std::string label, int64_t bytes_max);

  // Keeps the pool in a new file from now on. Errors: those of Journal::Create.
  absl::Status Keep(const std::string& path, JournaledPool pool, Metrics* metrics);
  // Continues the log and the file of an earlier process. REQUIRES: the log is empty.
  void Resume(const std::string& path, const JournaledPool& pool, Metrics* metrics);

  const RequestLog& requests() const { return requests_; }
  // Errors: RESOURCE_EXHAUSTED the log has no room for another entry. `may_shorten`: the entry may
  // allow a later checkpoint, and therefore gets an eighth more room.
  absl::Status CheckRoom(bool may_shorten) const;
  // Adds an entry and returns its number.
  int64_t Append(LoggedRequest logged);
  // Removes the last entry.
  void RemoveLast();
  // Drops the entries up to `number` from memory.
  void ForgetUpTo(int64_t number) { requests_.ForgetUpTo(number); }

  // Sets the checkpoint of one shard.
  void SetCheckpoint(Part range, std::shared_ptr<const ShardCheckpoint> checkpoint);
  // Replaces the shards and their checkpoints.
  void SetCheckpoints(ShardCheckpoints checkpoints);
  // Removes the file.
  void Discard();

 private:
  const std::string label_;
  const int32_t frame_stack_;
  const int64_t bytes_max_;
  RequestLog requests_;
  std::unique_ptr<Journal> journal_;  // null: the pool is not kept
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_POOL_LOG_H_
