#include "server/fleet/journal.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "procgen/v1/states.pb.h"
#include "server/session/event_log.h"

namespace procgen {
namespace {

// The kinds of records. Files outlive the program: no number may be used for something else.
enum class Kind : uint8_t {
  kPool = 1,      // a v1::Pool; the first record
  kLogBegin = 2,  // two numbers of 64 bits: log_begin and sequence_begin
  kRequest = 3,   // a v1::StepPoolRequest
  kStates = 4,    // a v1::RestoreStatesRequest
  kTakeBack = 5,  // nothing: the last request or states were not carried out
  kDivision = 6,  // nothing: there are no shards but those that follow
  kBase = 7,      // a Base
};

// The first line of a file: what it is, and the version of all that follows.
constexpr absl::string_view kTitle = "procgen-pool ";
constexpr absl::string_view kVersion = "1";

// Before the content of a record: its kind, its size, its checksum, and the checksum of these. So a
// size that is damaged is not taken for that of a record that was cut off.
constexpr size_t kHeadBytes = 1 + 4 + 4 + 4;
constexpr size_t kHeadSumAt = kHeadBytes - 4;

// A file is written anew when it is that much larger than it was the last time.
constexpr int64_t kGrowthBytes = int64_t{16} << 20;

void AddNumber(uint32_t number, std::string* bytes) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes->push_back(static_cast<char>(number >> shift));
  }
}

uint32_t NumberAt(absl::string_view bytes) {
  uint32_t number = 0;
  for (size_t i = 0; i < 4; ++i) {
    number |= uint32_t{static_cast<uint8_t>(bytes[i])} << (8 * i);
  }
  return number;
}

void AddLongNumber(int64_t number, std::string* bytes) {
  AddNumber(static_cast<uint32_t>(number), bytes);
  AddNumber(static_cast<uint32_t>(number >> 32), bytes);
}

int64_t LongNumberAt(absl::string_view bytes) {
  return static_cast<int64_t>(uint64_t{NumberAt(bytes.substr(4))} << 32 | NumberAt(bytes));
}

uint32_t ChecksumOf(absl::string_view content) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size()));
}

std::string Record(Kind kind, absl::string_view content = {}) {
  std::string record;
  record.push_back(static_cast<char>(kind));
  AddNumber(static_cast<uint32_t>(content.size()), &record);
  AddNumber(ChecksumOf(content), &record);
  AddNumber(ChecksumOf(record), &record);
  record.append(content.data(), content.size());
  return record;
}

std::string RecordOf(const LoggedRequest& logged) {
  if (logged.states.empty()) {
    return Record(Kind::kRequest, logged.request.SerializeAsString());
  }
  v1::RestoreStatesRequest states;
  states.mutable_states()->Add(logged.states.begin(), logged.states.end());
  return Record(Kind::kStates, states.SerializeAsString());
}

// A base in messages of the contract, one after the other, each after its size: a response with its
// states and its number, a slice with its range, and the sampler, if there is one.
std::string RecordOf(Part range, const ShardBase& base) {
  v1::SaveStatesResponse states;
  states.set_sequence_number(base.number);
  for (const std::string& state : base.states) {
    states.add_states()->set_snapshot(state);
  }
  v1::Slice slice;
  slice.set_first_environment(range.first);
  slice.set_environment_count(range.count);
  std::string content;
  const auto add = [&content](const google::protobuf::MessageLite& message) {
    const std::string bytes = message.SerializeAsString();
    AddNumber(static_cast<uint32_t>(bytes.size()), &content);
    content.append(bytes);
  };
  add(states);
  add(slice);
  if (base.sampler != nullptr) {
    add(*base.sampler);
  }
  return Record(Kind::kBase, content);
}

// The next message of a base.
bool TakeMessage(absl::string_view* content, google::protobuf::MessageLite* message) {
  if (content->size() < 4 || NumberAt(*content) > content->size() - 4) {
    return false;
  }
  const absl::string_view bytes = content->substr(4, NumberAt(*content));
  content->remove_prefix(4 + bytes.size());
  return message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

bool ReadBase(absl::string_view content, ShardBases* bases) {
  v1::SaveStatesResponse states;
  v1::Slice slice;
  if (!TakeMessage(&content, &states) || !TakeMessage(&content, &slice)) {
    return false;
  }
  ShardBase base;
  base.number = states.sequence_number();
  for (v1::State& state : *states.mutable_states()) {
    base.states.push_back(std::move(*state.mutable_snapshot()));
  }
  if (!content.empty()) {
    auto sampler = std::make_shared<v1::LevelSampler>();
    if (!TakeMessage(&content, sampler.get())) {
      return false;
    }
    base.sampler = std::move(sampler);
  }
  const Part range = {slice.first_environment(), slice.environment_count()};
  (*bases)[range.first] = {range, std::make_shared<const ShardBase>(std::move(base))};
  return true;
}

bool ReadRecord(Kind kind, absl::string_view content, JournaledPool* pool) {
  const int size = static_cast<int>(content.size());
  switch (kind) {
    case Kind::kPool:
      return pool->pool.ParseFromArray(content.data(), size);
    case Kind::kLogBegin:
      if (content.size() != 16) {
        return false;
      }
      pool->log_begin = LongNumberAt(content);
      pool->sequence_begin = LongNumberAt(content.substr(8));
      return true;
    case Kind::kRequest:
      pool->log.emplace_back();
      return pool->log.back().request.ParseFromArray(content.data(), size);
    case Kind::kStates: {
      v1::RestoreStatesRequest states;
      const bool ok = states.ParseFromArray(content.data(), size);
      pool->log.emplace_back();
      pool->log.back().states.assign(states.states().begin(), states.states().end());
      return ok;
    }
    case Kind::kTakeBack:
      if (pool->log.empty()) {
        return false;
      }
      pool->log.pop_back();
      return true;
    case Kind::kDivision:
      pool->bases.clear();
      return true;
    case Kind::kBase:
      return ReadBase(content, &pool->bases);
  }
  return false;
}

// Takes the first line from `bytes`.
absl::Status TakeTitle(const std::string& path, absl::string_view* bytes) {
  if (!absl::ConsumePrefix(bytes, kTitle)) {
    return absl::DataLossError(absl::StrCat(path, " is no journal of a pool"));
  }
  const absl::string_view version = bytes->substr(0, bytes->find('\n'));
  if (version != kVersion) {
    return absl::FailedPreconditionError(
        absl::StrCat(path, " is a journal of version '", absl::CHexEscape(version.substr(0, 16)),
                     "', allowed: ", kVersion, "; the server that wrote it can read it"));
  }
  bytes->remove_prefix(version.size() + 1);
  return absl::OkStatus();
}

std::string SystemError(absl::string_view what, const std::string& path) {
  return absl::StrCat(what, " ", path, ": ", std::strerror(errno));
}

bool WriteAll(int file, absl::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) {
      return false;
    }
    bytes.remove_prefix(static_cast<size_t>(std::max<ssize_t>(written, 0)));
  }
  return true;
}

}  // namespace

int64_t JournaledPool::next_sequence_number() const {
  int64_t last = sequence_begin;
  for (const LoggedRequest& logged : log) {
    last = std::max(last, logged.request.sequence_number());
  }
  return last + 1;
}

absl::StatusOr<JournaledPool> Journal::Read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return absl::NotFoundError(SystemError("cannot read", path));
  }
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  JournaledPool pool;
  absl::string_view rest = bytes;
  if (absl::Status status = TakeTitle(path, &rest); !status.ok()) {
    return status;
  }
  const auto damaged = [&] {
    return absl::DataLossError(
        absl::StrCat(path, " is damaged at byte ", bytes.size() - rest.size()));
  };
  while (rest.size() >= kHeadBytes) {
    if (NumberAt(rest.substr(kHeadSumAt)) != ChecksumOf(rest.substr(0, kHeadSumAt))) {
      return damaged();
    }
    const auto kind = static_cast<Kind>(rest[0]);
    const size_t size = NumberAt(rest.substr(1));
    if (size > rest.size() - kHeadBytes) {
      break;  // the process was killed while it wrote this
    }
    const absl::string_view content = rest.substr(kHeadBytes, size);
    if (NumberAt(rest.substr(5)) != ChecksumOf(content) || !ReadRecord(kind, content, &pool)) {
      return damaged();
    }
    rest.remove_prefix(kHeadBytes + size);
  }
  if (pool.pool.name().empty() || pool.bases.empty()) {
    return absl::DataLossError(absl::StrCat(path, " holds no pool"));
  }
  return pool;
}

absl::StatusOr<std::unique_ptr<Journal>> Journal::Create(const std::string& path,
                                                         JournaledPool pool) {
  std::unique_ptr<Journal> journal(new Journal(path, std::move(pool)));
  absl::MutexLock lock(&journal->mutex_);
  if (absl::Status status = journal->Rewrite(); !status.ok()) {
    return status;
  }
  return journal;
}

Journal::Journal(std::string path, JournaledPool pool)
    : path_(std::move(path)),
      pool_(std::move(pool.pool)),
      bases_(std::move(pool.bases)),
      log_begin_(pool.log_begin),
      sequence_begin_(pool.sequence_begin) {
  absl::MutexLock lock(&mutex_);
  for (const LoggedRequest& logged : pool.log) {
    log_.push_back({RecordOf(logged), logged.request.sequence_number()});
  }
}

Journal::~Journal() {
  absl::MutexLock lock(&mutex_);
  if (file_ >= 0) {
    close(file_);
  }
}

void Journal::Append(const LoggedRequest& logged) {
  absl::MutexLock lock(&mutex_);
  log_.push_back({RecordOf(logged), logged.request.sequence_number()});
  Write(log_.back().record);
}

void Journal::TakeBack() {
  absl::MutexLock lock(&mutex_);
  log_.pop_back();
  Write(Record(Kind::kTakeBack));
}

void Journal::SetBase(Part range, std::shared_ptr<const ShardBase> base) {
  const std::string record = RecordOf(range, *base);
  absl::MutexLock lock(&mutex_);
  bases_[range.first] = {range, std::move(base)};
  Write(record);
  Trim();
  RewriteIfLarge();
}

void Journal::SetBases(ShardBases bases) {
  absl::MutexLock lock(&mutex_);
  bases_ = std::move(bases);
  std::string records = Record(Kind::kDivision);
  for (const auto& [first, base] : bases_) {
    records += RecordOf(base.first, *base.second);
  }
  Write(records);
  Trim();
  RewriteIfLarge();
}

void Journal::Remove() {
  absl::MutexLock lock(&mutex_);
  if (file_ >= 0) {
    unlink(path_.c_str());
    close(std::exchange(file_, -1));
  }
}

void Journal::Trim() {
  int64_t needed = bases_.begin()->second.second->number;
  for (const auto& [first, base] : bases_) {
    needed = std::min(needed, base.second->number);
  }
  for (; log_begin_ < needed && !log_.empty(); ++log_begin_) {
    sequence_begin_ = std::max(sequence_begin_, log_.front().sequence_number);
    log_.pop_front();
  }
}

void Journal::RewriteIfLarge() {
  if (file_ < 0 || bytes_ < bytes_rewritten_ * 2 + kGrowthBytes) {
    return;
  }
  if (const absl::Status status = Rewrite(); !status.ok()) {
    Fail(status.message());
  }
}

absl::Status Journal::Rewrite() {
  std::string begin;
  AddLongNumber(log_begin_, &begin);
  AddLongNumber(sequence_begin_, &begin);
  std::string records = absl::StrCat(kTitle, kVersion, "\n");
  records += Record(Kind::kPool, pool_.SerializeAsString());
  records += Record(Kind::kLogBegin, begin);
  for (const auto& [first, base] : bases_) {
    records += RecordOf(base.first, *base.second);
  }
  for (const Entry& entry : log_) {
    records += entry.record;
  }
  const std::string beside = path_ + ".part";
  const int file = open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0 || !WriteAll(file, records) || rename(beside.c_str(), path_.c_str()) != 0) {
    absl::Status status = absl::UnavailableError(SystemError("cannot write", beside));
    if (file >= 0) {
      close(file);
      unlink(beside.c_str());
    }
    return status;
  }
  if (file_ >= 0) {
    close(file_);
  }
  file_ = file;
  bytes_ = static_cast<int64_t>(records.size());
  bytes_rewritten_ = bytes_;
  return absl::OkStatus();
}

void Journal::Write(const std::string& records) {
  if (file_ < 0) {
    return;
  }
  if (!WriteAll(file_, records)) {
    Fail(SystemError("cannot write", path_));
    return;
  }
  bytes_ += static_cast<int64_t>(records.size());
}

void Journal::Fail(absl::string_view message) {
  // Half of what happened is worse than nothing: a learner would be told that it never was.
  LogEvent(LogLevel::kError, "pool_not_kept",
           {{"pool", pool_.name()}, {"owner", pool_.owner()}, {"message", std::string(message)}});
  unlink(path_.c_str());
  close(std::exchange(file_, -1));
}

}  // namespace procgen
