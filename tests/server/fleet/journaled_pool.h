#ifndef TESTS_SERVER_FLEET_JOURNALED_POOL_H_
#define TESTS_SERVER_FLEET_JOURNALED_POOL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/fleet/log/journal.h"

namespace procgen {

// A checkpoint of a shard of two environments, with `text` in its states.
inline std::shared_ptr<const ShardCheckpoint> SomeCheckpoint(int64_t number,
                                                             const std::string& text) {
  ShardCheckpoint checkpoint;
  checkpoint.number = number;
  checkpoint.states = {text + "-0", text + std::string("\0-1", 3)};
  return std::make_shared<const ShardCheckpoint>(std::move(checkpoint));
}

// A step of all four environments.
inline LoggedRequest SomeStep(int64_t sequence_number) {
  LoggedRequest logged;
  logged.request.set_sequence_number(sequence_number);
  logged.request.mutable_step()->mutable_slice()->set_env_count(4);
  for (int32_t i = 0; i < 4; ++i) {
    logged.request.mutable_step()->add_actions(static_cast<int32_t>(sequence_number) + i);
  }
  return logged;
}

// Restored states of one environment.
inline LoggedRequest SomeStates(int32_t environment) {
  LoggedRequest logged;
  logged.states.emplace_back();
  logged.states.back().set_environment(environment);
  logged.states.back().set_snapshot("a snapshot");
  return logged;
}

inline RequestLog::Entry EntryOf(LoggedRequest logged) {
  return std::make_shared<const LoggedRequest>(std::move(logged));
}

// A pool of two shards after nine requests; the last two are in the log.
inline JournaledPool SomePool(const std::string& name = "pools/7") {
  JournaledPool pool;
  pool.pool.set_owner("alice");
  pool.pool.set_name(name);
  pool.pool.mutable_spec()->add_games("maze");
  pool.pool.mutable_spec()->set_env_count(4);
  pool.checkpoints[0] = {{0, 2}, SomeCheckpoint(7, "left")};
  pool.checkpoints[2] = {{2, 2}, SomeCheckpoint(7, "right")};
  pool.log_begin = 7;
  pool.sequence_begin = 5;
  pool.log = {EntryOf(SomeStep(6)), EntryOf(SomeStates(3))};
  return pool;
}

}  // namespace procgen

#endif  // TESTS_SERVER_FLEET_JOURNALED_POOL_H_
