#ifndef SERVER_FLEET_LOG_DATABASE_H_
#define SERVER_FLEET_LOG_DATABASE_H_

#include <sqlite3.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <variant>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// A value of a row: NULL, a number, or borrowed bytes.
using SqlValue = std::variant<std::monostate, int64_t, absl::string_view>;

// A connection to an SQLite database in one file, with a write-ahead log beside it. Only one
// connection may be open at a time. A commit is written when it returns, and synced with the next
// checkpoint of the write-ahead log. It survives a crash of the process; after a power cut the file
// may hold an earlier commit.
//
// The first error is final: later calls do nothing, and status() returns that error.
// Errors: DATA_LOSS the file is damaged or no database; UNAVAILABLE a system error.
// Threads: compatible.
class Database {
 public:
  // `create`: create the file if it does not exist.
  Database(const std::string& path, bool create);
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  const std::string& path() const { return path_; }
  const absl::Status& status() const { return status_; }
  void Fail(const absl::Status& status) { status_.Update(status); }

  // Executes one statement with `values` as its parameters, and passes each row to `visit`.
  void Run(
      absl::string_view sql, absl::Span<const SqlValue> values = {},
      absl::FunctionRef<void(absl::Span<const SqlValue>)> visit = [](auto) {});
  // Copies the write-ahead log into the file, syncs both, and frees the log's disk space. Also runs
  // after an error, which remains.
  void Checkpoint();

  // The path of a database's write-ahead log.
  static std::string WriteAheadLogOf(const std::string& path) { return path + "-wal"; }
  // Returns the value of a checksum column; SQLite has none in the file's own pages.
  static int64_t ChecksumOf(absl::Span<const SqlValue> values);

 private:
  struct Close {
    void operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }
  };
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };

  // Updates status_ from a result code. Returns whether it is no error.
  bool Check(int code);

  const std::string path_;
  absl::Status status_;
  std::unique_ptr<sqlite3, Close> connection_;
  std::map<std::string, std::unique_ptr<sqlite3_stmt, Finalize>, std::less<>> statements_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_DATABASE_H_
