#include "server/fleet/log/database.h"

#include <zlib.h>

#include <cstring>
#include <vector>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

constexpr absl::string_view kSetUp[] = {
    // With one connection: no WAL index in shared memory, no lock per transaction.
    "PRAGMA locking_mode = EXCLUSIVE",  "PRAGMA synchronous = NORMAL",
    "PRAGMA wal_autocheckpoint = 4096",  // pages: 16 MiB
    "PRAGMA cache_size = -256",          // KiB
    "PRAGMA secure_delete = OFF",       "PRAGMA cell_size_check = ON",
    "PRAGMA trusted_schema = OFF",
};

SqlValue ColumnOf(sqlite3_stmt* statement, int column) {
  switch (sqlite3_column_type(statement, column)) {
    case SQLITE_NULL:
      return std::monostate();
    case SQLITE_INTEGER:
      return sqlite3_column_int64(statement, column);
    default: {
      const auto* const bytes =
          static_cast<const char*>(sqlite3_column_blob(statement, column));  // before its size
      return absl::string_view(bytes, static_cast<size_t>(sqlite3_column_bytes(statement, column)));
    }
  }
}

int Bind(sqlite3_stmt* statement, int place, const SqlValue& value) {
  if (const auto* number = std::get_if<int64_t>(&value)) {
    return sqlite3_bind_int64(statement, place, *number);
  }
  if (const auto* bytes = std::get_if<absl::string_view>(&value)) {
    // A null pointer would be bound as NULL, not as an empty blob.
    return sqlite3_bind_blob64(statement, place, bytes->empty() ? "" : bytes->data(), bytes->size(),
                               SQLITE_STATIC);
  }
  return sqlite3_bind_null(statement, place);
}

}  // namespace

Database::Database(const std::string& path, bool create) : path_(path) {
  sqlite3* connection = nullptr;
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | (create ? SQLITE_OPEN_CREATE : 0);
  const int code = sqlite3_open_v2(path.c_str(), &connection, flags, nullptr);
  connection_.reset(connection);
  if (!Check(code)) {
    return;
  }
  // Closing does not checkpoint: the file changes only on writes, and closing is fast.
  sqlite3_db_config(connection, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  for (const absl::string_view sql : kSetUp) {
    Run(sql);
  }
  if (create) {
    Run("PRAGMA journal_mode = WAL");  // stored in the file
  }
}

bool Database::Check(int code) {
  switch (code & 0xff) {
    case SQLITE_OK:
    case SQLITE_ROW:
    case SQLITE_DONE:
      return true;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_TOOBIG:
    case SQLITE_ERROR:  // such as a missing table
      Fail(absl::DataLossError(
          absl::StrCat(path_, " is damaged: ", sqlite3_errmsg(connection_.get()))));
      return false;
    default: {
      const int error = sqlite3_system_errno(connection_.get());
      Fail(absl::UnavailableError(absl::StrCat("cannot use ", path_, ": ", sqlite3_errstr(code),
                                               error == 0 ? "" : ": ",
                                               error == 0 ? "" : std::strerror(error))));
      return false;
    }
  }
}

void Database::Run(absl::string_view sql, absl::Span<const SqlValue> values,
                   absl::FunctionRef<void(absl::Span<const SqlValue>)> visit) {
  if (!status_.ok()) {
    return;
  }
  auto found = statements_.find(sql);
  if (found == statements_.end()) {
    sqlite3_stmt* made = nullptr;
    const int code = sqlite3_prepare_v2(connection_.get(), sql.data(), static_cast<int>(sql.size()),
                                        &made, nullptr);
    found = statements_.emplace(sql, made).first;
    if (!Check(code)) {
      return;
    }
  }
  sqlite3_stmt* const statement = found->second.get();
  for (size_t i = 0; i < values.size(); ++i) {
    if (!Check(Bind(statement, static_cast<int>(i) + 1, values[i]))) {
      return;
    }
  }
  std::vector<SqlValue> row(static_cast<size_t>(sqlite3_column_count(statement)));
  int code = SQLITE_OK;
  while (status_.ok() && (code = sqlite3_step(statement)) == SQLITE_ROW) {
    for (size_t i = 0; i < row.size(); ++i) {
      row[i] = ColumnOf(statement, static_cast<int>(i));
    }
    visit(row);
  }
  Check(code);
  sqlite3_reset(statement);
}

void Database::Checkpoint() {
  if (connection_ == nullptr) {
    return;
  }
  if (sqlite3_get_autocommit(connection_.get()) == 0) {
    sqlite3_exec(connection_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Check(sqlite3_wal_checkpoint_v2(connection_.get(), nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr,
                                  nullptr));
}

int64_t Database::ChecksumOf(absl::Span<const SqlValue> values) {
  uLong sum = crc32_z(0, nullptr, 0);
  const auto add = [&sum](const void* bytes, size_t size) {
    sum = crc32_z(sum, static_cast<const Bytef*>(bytes), size);
  };
  for (const SqlValue& value : values) {
    int64_t head[2] = {static_cast<int64_t>(value.index()), 0};
    if (const auto* bytes = std::get_if<absl::string_view>(&value)) {
      head[1] = static_cast<int64_t>(bytes->size());
    } else if (const auto* number = std::get_if<int64_t>(&value)) {
      head[1] = *number;
    }
    add(head, sizeof(head));
    if (const auto* bytes = std::get_if<absl::string_view>(&value);
        bytes != nullptr && !bytes->empty()) {
      add(bytes->data(), bytes->size());
    }
  }
  return static_cast<int64_t>(sum);
}

}  // namespace procgen
