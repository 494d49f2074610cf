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

// A pool as its database holds it.
struct JournaledPool {
  v1::Pool pool;  // its owner, name, and spec with the level sampler that it was made with
  ShardCheckpoints checkpoints;
  // The number before the first of `log`, and the sequence number of the last request before it.
  int64_t log_begin = 0;
  int64_t sequence_begin = 0;
  std::vector<RequestLog::Entry> log;

  int64_t next_sequence_number() const;
};

// Keeps a pool in a database of its own, so that the next process can continue it: what it is, the
// checkpoints of its shards, and the requests since. Each change is committed before the call
// returns: it survives the process, not always a power cut, after which the database holds an
// earlier commit.
//
// A write that fails loses nothing: the journal has in memory what the database lacks, and retries
// with later changes. Meanwhile the database holds the last commit.
// Threads: any method from any thread.
class Journal {
 public:
  // Makes the file and syncs it. `metrics` must outlive this. Errors: those of Database; then there
  // is no file.
  static absl::StatusOr<std::unique_ptr<Journal>> Create(const std::string& path,
                                                         JournaledPool pool, Metrics* metrics);
  // Reads what an earlier process left; writes nothing. Errors: those of Database;
  // FAILED_PRECONDITION another version of the server wrote it.
  static absl::StatusOr<JournaledPool> Read(const std::string& path);
  // Continues the file that `pool` was read from.
  static std::unique_ptr<Journal> Resume(const std::string& path, JournaledPool pool,
                                         Metrics* metrics);

  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // Adds what was asked of the pool next.
  void Append(RequestLog::Entry logged);
  // Takes the last one back: it was not carried out after all.
  void TakeBack();
  // A shard has a new checkpoint.
  void SetCheckpoint(Part range, std::shared_ptr<const ShardCheckpoint> checkpoint);
  // The pool has other shards.
  void SetCheckpoints(ShardCheckpoints checkpoints);
  // Removes the file: there is no such pool any more.
  void Remove();

 private:
  Journal(std::string path, JournaledPool pool, Metrics* metrics, bool is_new);
  int64_t log_end() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return log_begin_ + static_cast<int64_t>(log_.size());
  }
  // The sequence number of the last request up to `number` of the log.
  int64_t SequenceAt(int64_t number) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Brings the database to what the memory holds. After a failure only where `must_try`, or when
  // the log has grown so much that trying costs little beside it.
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
  bool is_new_ ABSL_GUARDED_BY(mutex_);                         // nothing has been committed
  bool is_removed_ ABSL_GUARDED_BY(mutex_) = false;
  ShardCheckpoints checkpoints_ ABSL_GUARDED_BY(mutex_);
  int64_t log_begin_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t sequence_begin_ ABSL_GUARDED_BY(mutex_) = 0;
  std::deque<RequestLog::Entry> log_ ABSL_GUARDED_BY(mutex_);
  // What the database lacks: entries after this number, and checkpoints, by first environment.
  int64_t written_end_ ABSL_GUARDED_BY(mutex_) = 0;
  std::set<int32_t> unwritten_checkpoints_ ABSL_GUARDED_BY(mutex_);
  bool is_failing_ ABSL_GUARDED_BY(mutex_) = false;
  int64_t retry_end_ ABSL_GUARDED_BY(mutex_) = 0;  // end of the log at which to try again
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_JOURNAL_H_
