#ifndef SERVER_FLEET_LOG_JOURNAL_H_
#define SERVER_FLEET_LOG_JOURNAL_H_

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "procgen/v1/pools.pb.h"
#include "server/fleet/log/database.h"
#include "server/fleet/log/request_log.h"
#include "server/fleet/log/shard_checkpoint.h"
#include "server/metrics/metrics.h"
#include "server/session/backend/request.h"

namespace procgen {

// Checkpoints of a pool's shards, by the first environment of each.
using ShardCheckpoints = std::map<int32_t, std::pair<Part, std::shared_ptr<const ShardCheckpoint>>>;

// The content of a pool's database.
struct JournaledPool {
  v1::Pool pool;  // owner, name, and the spec with its initial level sampler
  ShardCheckpoints checkpoints;
  // The number before the first of `log`, and the sequence number of the last request before it.
  int64_t log_begin = 0;
  int64_t sequence_begin = 0;
  std::vector<RequestLog::Entry> log;

  int64_t next_sequence_number() const;
};

// A pool's database for the next process: its spec, the checkpoints of its shards, and the requests
// since. Each change is committed before the call returns. It survives a crash of the process;
// after a power cut the database may hold an earlier commit.
// earlier commit.
//
// A failed write loses nothing: the journal holds in memory what is not written, and retries with
// later changes. Meanwhile the database holds the last commit.
// Threads: any method from any thread.
class Journal {
 public:
  // Creates the file and syncs it. `metrics` must outlive this. Errors: those of Database; then
  // there is no file.
  static absl::StatusOr<std::unique_ptr<Journal>> Create(const std::string& path,
                                                         JournaledPool pool, Metrics* metrics);
  // Reads the file of an earlier process; writes nothing. Errors: those of Database;
  // FAILED_PRECONDITION another version of the server wrote it.
  static absl::StatusOr<JournaledPool> Read(const std::string& path);
  // Continues the file that `pool` was read from.
  static std::unique_ptr<Journal> Resume(const std::string& path, JournaledPool pool,
                                         Metrics* metrics);

  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // Appends an entry to the log.
  void Append(RequestLog::Entry logged);
  // Removes the last entry, which was not executed.
  void RemoveLast();
  // Sets the checkpoint of one shard.
  void SetCheckpoint(Part range, std::shared_ptr<const ShardCheckpoint> checkpoint);
  // Replaces the shards and their checkpoints.
  void SetCheckpoints(ShardCheckpoints checkpoints);
  // Deletes the file, because the pool was deleted.
  void Remove();

 private:
  Journal(std::string path, JournaledPool pool, Metrics* metrics, bool is_new);
  int64_t log_end() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return log_begin_ + static_cast<int64_t>(log_.size());
  }
  // The sequence number of the last request at or before entry `number`.
  int64_t SequenceAt(int64_t number) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Writes the changes in memory to the database. After a failure it tries only if `must_try`, or
  // when the log has grown enough that an attempt costs little in comparison.
  void Commit(bool must_try = false) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status TryCommit() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void WriteAll() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SetFailing(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Drops entries that no checkpoint needs.
  void Trim() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string path_;
  const v1::Pool pool_;
  Metrics* const metrics_;

  absl::Mutex mutex_;
  std::unique_ptr<Database> database_ ABSL_GUARDED_BY(mutex_);  // null: to be opened
  bool is_new_ ABSL_GUARDED_BY(mutex_);                         // nothing was committed yet
  bool is_removed_ ABSL_GUARDED_BY(mutex_) = false;
  ShardCheckpoints checkpoints_ ABSL_GUARDED_BY(mutex_);
  int64_t log_begin_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t sequence_begin_ ABSL_GUARDED_BY(mutex_) = 0;
  std::deque<RequestLog::Entry> log_ ABSL_GUARDED_BY(mutex_);
  // Not in the database yet: entries after this number, and checkpoints, by first environment.
  int64_t written_end_ ABSL_GUARDED_BY(mutex_) = 0;
  std::set<int32_t> unwritten_checkpoints_ ABSL_GUARDED_BY(mutex_);
  bool is_failing_ ABSL_GUARDED_BY(mutex_) = false;
  int64_t retry_end_ ABSL_GUARDED_BY(mutex_) = 0;  // end of the log at which to retry
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_JOURNAL_H_
