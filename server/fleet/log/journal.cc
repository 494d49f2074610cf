#include "server/fleet/log/journal.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "absl/algorithm/container.h"
#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "procgen/v1/states.pb.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

using Row = absl::Span<const SqlValue>;

// Version of the schema and its content; files outlive the program. Version 1 was a custom format,
// whose files begin with this.
constexpr int64_t kVersion = 2;
constexpr absl::string_view kVersion1Title = "procgen-pool 1\n";

// `pool.content` is a v1::Pool; `log.content` a v1::RestoreStatesRequest (is_states) or a
// v1::StepPoolRequest. `checkpoint.states` is a v1::SaveStatesResponse; `sequence_number` that of
// the last request before it.
constexpr absl::string_view kSchema[] = {
    "CREATE TABLE checkpoint (first_env INTEGER PRIMARY KEY, env_count INTEGER, number INTEGER,"
    " sequence_number INTEGER, states BLOB, level_sampler BLOB, checksum INTEGER)",
    "CREATE TABLE log (number INTEGER PRIMARY KEY, is_states INTEGER, content BLOB,"
    " checksum INTEGER)",
    "CREATE TABLE pool (content BLOB, checksum INTEGER)",
};

// Minimum number of further entries before a failed write is retried.
constexpr int64_t kRetryEntries = 16;

// Executes `sql` with `values` and, after them, their checksum.
void Insert(absl::string_view sql, std::vector<SqlValue> values, Database* database) {
  values.emplace_back(Database::ChecksumOf(values));
  database->Run(sql, values);
}

// Reads the rows of `sql`, whose last column is the checksum of the others. `read` returns whether
// a row is valid.
void ReadRows(absl::string_view sql, absl::FunctionRef<bool(Row)> read, Database* database) {
  int number = 0;
  database->Run(sql, {}, [&](Row row) {
    ++number;
    const auto* const sum = std::get_if<int64_t>(&row.back());
    const Row values = row.first(row.size() - 1);
    if (sum == nullptr || *sum != Database::ChecksumOf(values) || !read(values)) {
      database->Fail(absl::DataLossError(
          absl::StrCat(database->path(), " is damaged: row ", number, " of ", sql)));
    }
  });
}

int64_t NumberOf(const SqlValue& value) { return std::get<int64_t>(value); }

bool Parse(const SqlValue& value, google::protobuf::MessageLite* message) {
  const auto bytes = std::get<absl::string_view>(value);
  return message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

bool ReadCheckpoint(Row row, JournaledPool* pool) {
  v1::SaveStatesResponse states;
  ShardCheckpoint checkpoint;
  checkpoint.number = NumberOf(row[2]);
  if (!Parse(row[4], &states)) {
    return false;
  }
  for (v1::State& state : *states.mutable_states()) {
    checkpoint.states.push_back(std::move(*state.mutable_snapshot()));
  }
  if (!std::holds_alternative<std::monostate>(row[5])) {
    auto sampler = std::make_shared<v1::LevelSampler>();
    if (!Parse(row[5], sampler.get())) {
      return false;
    }
    checkpoint.sampler = std::move(sampler);
  }
  if (pool->checkpoints.empty() || checkpoint.number < pool->log_begin) {
    pool->log_begin = checkpoint.number;
    pool->sequence_begin = NumberOf(row[3]);
  }
  const Part range = {static_cast<int32_t>(NumberOf(row[0])),
                      static_cast<int32_t>(NumberOf(row[1]))};
  pool->checkpoints[range.first] = {range,
                                    std::make_shared<const ShardCheckpoint>(std::move(checkpoint))};
  return true;
}

bool ReadLogged(Row row, JournaledPool* pool) {
  LoggedRequest logged;
  if (NumberOf(row[0]) != pool->log_begin + static_cast<int64_t>(pool->log.size()) + 1) {
    return false;
  }
  if (NumberOf(row[1]) == 0) {
    if (!Parse(row[2], &logged.request)) {
      return false;
    }
  } else {
    v1::RestoreStatesRequest states;
    if (!Parse(row[2], &states)) {
      return false;
    }
    logged.states.assign(states.states().begin(), states.states().end());
  }
  pool->log.push_back(std::make_shared<const LoggedRequest>(std::move(logged)));
  return true;
}

void WriteSchema(const v1::Pool& pool, Database* database) {
  for (const absl::string_view sql : kSchema) {
    database->Run(sql);
  }
  database->Run(absl::StrCat("PRAGMA user_version = ", kVersion));
  const std::string content = pool.SerializeAsString();
  Insert("INSERT INTO pool VALUES (?, ?)", {content}, database);
}

void WriteCheckpoint(Part range, const ShardCheckpoint& checkpoint, int64_t sequence_number,
                     Database* database) {
  v1::SaveStatesResponse states;
  for (const std::string& state : checkpoint.states) {
    states.add_states()->set_snapshot(state);
  }
  const std::string content = states.SerializeAsString();
  const std::string sampler =
      checkpoint.sampler == nullptr ? "" : checkpoint.sampler->SerializeAsString();
  Insert("INSERT OR REPLACE INTO checkpoint VALUES (?, ?, ?, ?, ?, ?, ?)",
         {int64_t{range.first}, int64_t{range.count}, checkpoint.number, sequence_number, content,
          checkpoint.sampler == nullptr ? SqlValue() : sampler},
         database);
}

void WriteLogged(int64_t number, const LoggedRequest& logged, Database* database) {
  std::string content;
  if (logged.states.empty()) {
    content = logged.request.SerializeAsString();
  } else {
    v1::RestoreStatesRequest states;
    states.mutable_states()->Add(logged.states.begin(), logged.states.end());
    content = states.SerializeAsString();
  }
  Insert("INSERT OR REPLACE INTO log VALUES (?, ?, ?, ?)",
         {number, int64_t{logged.states.empty() ? 0 : 1}, content}, database);
}

// Whether the checkpoints cover all environments and none is after the log.
bool IsWhole(const JournaledPool& pool) {
  int32_t end = 0;
  for (const auto& [first, checkpoint] : pool.checkpoints) {
    const auto& [range, states] = checkpoint;
    if (first != end || range.count < 1 ||
        states->number > pool.log_begin + static_cast<int64_t>(pool.log.size()) ||
        (!states->states.empty() && states->states.size() != static_cast<size_t>(range.count))) {
      return false;
    }
    end += range.count;
  }
  return !pool.pool.name().empty() && end > 0 && end == pool.pool.spec().env_count();
}

absl::Status CheckVersion(const std::string& path, Database* database) {
  std::string title(kVersion1Title.size(), '\0');
  std::ifstream(path, std::ios::binary)
      .read(title.data(), static_cast<std::streamsize>(title.size()));
  int64_t version = title == kVersion1Title ? 1 : kVersion;
  if (version == kVersion) {
    database->Run("PRAGMA user_version", {}, [&](Row row) { version = NumberOf(row[0]); });
  }
  if (version == 1 || (database->status().ok() && version != kVersion && version != 0)) {
    return absl::FailedPreconditionError(absl::StrCat(path, " is a journal of version ", version,
                                                      ", allowed: ", kVersion,
                                                      "; the server that wrote it can read it"));
  }
  return database->status();
}

}  // namespace

int64_t JournaledPool::next_sequence_number() const {
  int64_t last = sequence_begin;
  for (const RequestLog::Entry& logged : log) {
    last = std::max(last, logged->request.sequence_number());
  }
  return last + 1;
}

absl::StatusOr<JournaledPool> Journal::Read(const std::string& path) {
  Database database(path, /*create=*/false);
  if (absl::Status status = CheckVersion(path, &database); !status.ok()) {
    return status;
  }
  JournaledPool pool;
  database.Run("PRAGMA integrity_check(1)", {}, [&](Row row) {
    if (std::get<absl::string_view>(row[0]) != "ok") {
      database.Fail(absl::DataLossError(
          absl::StrCat(path, " is damaged: ", std::get<absl::string_view>(row[0]))));
    }
  });
  std::vector<std::string> schema;
  database.Run("SELECT sql FROM sqlite_schema ORDER BY name", {},
               [&](Row row) { schema.emplace_back(std::get<absl::string_view>(row[0])); });
  if (!absl::c_equal(schema, kSchema)) {
    database.Fail(absl::DataLossError(absl::StrCat(path, " is damaged: it has other tables")));
  }
  ReadRows(
      "SELECT content, checksum FROM pool", [&](Row row) { return Parse(row[0], &pool.pool); },
      &database);
  ReadRows(
      "SELECT first_env, env_count, number, sequence_number, states, level_sampler, checksum"
      " FROM checkpoint ORDER BY first_env",
      [&](Row row) { return ReadCheckpoint(row, &pool); }, &database);
  ReadRows(
      "SELECT number, is_states, content, checksum FROM log ORDER BY number",
      [&](Row row) { return ReadLogged(row, &pool); }, &database);
  if (database.status().ok() && !IsWhole(pool)) {
    return absl::DataLossError(absl::StrCat(path, " holds no complete pool"));
  }
  if (!database.status().ok()) {
    return database.status();
  }
  return pool;
}

absl::StatusOr<std::unique_ptr<Journal>> Journal::Create(const std::string& path,
                                                         JournaledPool pool, Metrics* metrics) {
  if (std::filesystem::exists(path)) {
    return absl::UnavailableError(absl::StrCat(path, " exists already"));
  }
  std::unique_ptr<Journal> journal(new Journal(path, std::move(pool), metrics, /*is_new=*/true));
  absl::Status status;
  {
    absl::MutexLock lock(&journal->mutex_);
    status = journal->TryCommit();
    if (status.ok()) {
      journal->database_->Checkpoint();  // so that it survives a power cut
      status = journal->database_->status();
    }
  }
  if (!status.ok()) {
    journal->Remove();
    return status;
  }
  return journal;
}

std::unique_ptr<Journal> Journal::Resume(const std::string& path, JournaledPool pool,
                                         Metrics* metrics) {
  return absl::WrapUnique(new Journal(path, std::move(pool), metrics, /*is_new=*/false));
}

Journal::Journal(std::string path, JournaledPool pool, Metrics* metrics, bool is_new)
    : path_(std::move(path)),
      pool_(std::move(pool.pool)),
      metrics_(metrics),
      is_new_(is_new),
      checkpoints_(std::move(pool.checkpoints)),
      log_begin_(pool.log_begin),
      sequence_begin_(pool.sequence_begin),
      log_(pool.log.begin(), pool.log.end()),
      written_end_(is_new ? log_begin_ : log_begin_ + static_cast<int64_t>(log_.size())) {
  for (const auto& [first, checkpoint] : checkpoints_) {
    if (is_new) {
      unwritten_checkpoints_.insert(first);
    }
  }
}

Journal::~Journal() {
  absl::MutexLock lock(&mutex_);
  if (is_failing_) {
    Commit(/*must_try=*/true);
  }
  SetFailing(absl::OkStatus());
}

void Journal::Append(RequestLog::Entry logged) {
  absl::MutexLock lock(&mutex_);
  log_.push_back(std::move(logged));
  Commit();
}

void Journal::RemoveLast() {
  absl::MutexLock lock(&mutex_);
  log_.pop_back();
  written_end_ = std::min(written_end_, log_end());
  Commit();
}

void Journal::SetCheckpoint(Part range, std::shared_ptr<const ShardCheckpoint> checkpoint) {
  absl::MutexLock lock(&mutex_);
  checkpoints_[range.first] = {range, std::move(checkpoint)};
  unwritten_checkpoints_.insert(range.first);
  Trim();
  Commit(/*must_try=*/true);
}

void Journal::SetCheckpoints(ShardCheckpoints checkpoints) {
  absl::MutexLock lock(&mutex_);
  checkpoints_ = std::move(checkpoints);
  unwritten_checkpoints_.clear();
  for (const auto& [first, checkpoint] : checkpoints_) {
    unwritten_checkpoints_.insert(first);
  }
  Trim();
  Commit(/*must_try=*/true);
}

void Journal::Remove() {
  absl::MutexLock lock(&mutex_);
  SetFailing(absl::OkStatus());
  is_removed_ = true;
  database_ = nullptr;
  std::error_code error;
  std::filesystem::remove(path_, error);
  std::filesystem::remove(Database::WriteAheadLogOf(path_), error);
}

int64_t Journal::SequenceAt(int64_t number) const {
  int64_t last = sequence_begin_;
  for (int64_t i = 0; i < number - log_begin_; ++i) {
    last = std::max(last, log_[static_cast<size_t>(i)]->request.sequence_number());
  }
  return last;
}

void Journal::Trim() {
  int64_t needed = log_end();
  for (const auto& [first, checkpoint] : checkpoints_) {
    needed = std::min(needed, checkpoint.second->number);
  }
  sequence_begin_ = SequenceAt(needed);
  for (; log_begin_ < needed; ++log_begin_) {
    log_.pop_front();
  }
}

void Journal::Commit(bool must_try) {
  if (is_removed_ || (is_failing_ && !must_try && log_end() < retry_end_)) {
    return;
  }
  absl::Status status = TryCommit();
  if (!status.ok() && !is_failing_) {
    status = TryCommit();  // there may be disk space now
  }
  SetFailing(status);
}

absl::Status Journal::TryCommit() {
  if (database_ == nullptr) {
    database_ = std::make_unique<Database>(path_, is_new_);
  }
  database_->Run("BEGIN");
  WriteAll();
  database_->Run("COMMIT");
  absl::Status status = database_->status();
  if (!status.ok()) {
    database_->Checkpoint();  // frees disk space
    database_ = nullptr;
    return status;
  }
  is_new_ = false;
  unwritten_checkpoints_.clear();
  written_end_ = log_end();
  return status;
}

void Journal::WriteAll() {
  if (is_new_) {
    WriteSchema(pool_, database_.get());
  }
  if (unwritten_checkpoints_.size() == checkpoints_.size()) {
    database_->Run("DELETE FROM checkpoint");  // including those of earlier shards
  }
  for (const int32_t first : unwritten_checkpoints_) {
    const auto& [range, checkpoint] = checkpoints_.at(first);
    WriteCheckpoint(range, *checkpoint, SequenceAt(checkpoint->number), database_.get());
  }
  if (!unwritten_checkpoints_.empty()) {
    database_->Run("DELETE FROM log WHERE number <= ?", {log_begin_});
  }
  database_->Run("DELETE FROM log WHERE number > ?", {written_end_});
  for (int64_t number = std::max(written_end_, log_begin_) + 1; number <= log_end(); ++number) {
    WriteLogged(number, *log_[static_cast<size_t>(number - log_begin_ - 1)], database_.get());
  }
}

void Journal::SetFailing(const absl::Status& status) {
  retry_end_ = log_end() + std::max<int64_t>(kRetryEntries, log_end() - written_end_);
  if (is_failing_ == !status.ok()) {
    return;
  }
  is_failing_ = !status.ok();
  metrics_->AddFleetNotDurable(is_failing_ ? 1 : -1);
  LogEvent(is_failing_ ? LogLevel::kError : LogLevel::kInfo,
           is_failing_ ? "journal_write_failed" : "journal_write_recovered",
           {{"pool", pool_.name()},
            {"owner", pool_.owner()},
            {"message", std::string(status.message())}});
}

}  // namespace procgen
