#ifndef SERVER_FLEET_JOURNAL_H_
#define SERVER_FLEET_JOURNAL_H_

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "procgen/v1/pools.pb.h"
#include "server/fleet/request_log.h"
#include "server/fleet/shard_base.h"
#include "server/session/request.h"

namespace procgen {

// Where the shards of a pool begin anew, by the first environment of each.
using ShardBases = std::map<int32_t, std::pair<Part, std::shared_ptr<const ShardBase>>>;

// A pool as a file keeps it.
struct JournaledPool {
  v1::Pool pool;  // its owner, name, and spec with the level sampler that it was made with
  ShardBases bases;
  // The number before the first of `log`, and the sequence number of the last request before it.
  int64_t log_begin = 0;
  int64_t sequence_begin = 0;
  std::vector<LoggedRequest> log;

  int64_t next_sequence_number() const;
};

// Keeps a pool in a file, so that a process that was killed can be followed by another that goes on
// where it was: what it is, the states that its shards begin anew from, and what was asked of it
// since. Each record is written at once, and not waited for: it survives the process, not the
// machine. A record that was cut off, the last, is not read.
//
// The file is written anew from time to time, so that it holds not much more than it needs.
// Threads: any method from any thread.
class Journal {
 public:
  // Makes the file. Errors: what the system says.
  static absl::StatusOr<std::unique_ptr<Journal>> Create(const std::string& path,
                                                         JournaledPool pool);
  // Reads what an earlier process left. Errors: NOT_FOUND; DATA_LOSS it is none, or damaged;
  // FAILED_PRECONDITION another version of the server wrote it.
  static absl::StatusOr<JournaledPool> Read(const std::string& path);

  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // What was asked of the pool next.
  void Append(const LoggedRequest& logged);
  // That it was not carried out after all.
  void TakeBack();
  // A shard has saved its states.
  void SetBase(Part range, std::shared_ptr<const ShardBase> base);
  // The pool was divided anew.
  void SetBases(ShardBases bases);
  // Removes the file: there is no such pool any more.
  void Remove();

 private:
  // An entry of the log, as it is in the file.
  struct Entry {
    std::string record;
    int64_t sequence_number = 0;  // 0: states
  };

  Journal(std::string path, JournaledPool pool);
  // Writes the whole file beside the old one, and puts it in its place.
  absl::Status Rewrite() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RewriteIfLarge() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Write(const std::string& records) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Fail(absl::string_view message) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Forgets what no base needs.
  void Trim() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string path_;
  const v1::Pool pool_;

  absl::Mutex mutex_;
  int file_ ABSL_GUARDED_BY(mutex_) = -1;  // -1: none, removed or broken
  ShardBases bases_ ABSL_GUARDED_BY(mutex_);
  int64_t log_begin_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t sequence_begin_ ABSL_GUARDED_BY(mutex_) = 0;
  std::deque<Entry> log_ ABSL_GUARDED_BY(mutex_);
  int64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;            // in the file
  int64_t bytes_rewritten_ ABSL_GUARDED_BY(mutex_) = 0;  // in it when it was written anew
};

}  // namespace procgen

#endif  // SERVER_FLEET_JOURNAL_H_
