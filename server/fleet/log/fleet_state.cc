#include "server/fleet/log/fleet_state.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <system_error>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

constexpr absl::string_view kPoolPrefix = "pool-";

}  // namespace

absl::StatusOr<std::shared_ptr<FleetState>> FleetState::Open(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  const int lock = open(absl::StrCat(path, "/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock < 0) {
    return absl::UnavailableError(
        absl::StrCat(path, ": cannot create a file: ", std::strerror(errno)));
  }
  std::shared_ptr<FleetState> state(new FleetState(path, lock));
  if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
    return absl::FailedPreconditionError(
        absl::StrCat(path, " is used by another process; give each fleet server its own"));
  }
  if (absl::Status status = state->ReadName(); !status.ok()) {
    return status;
  }
  return state;
}

FleetState::~FleetState() { close(lock_); }

absl::Status FleetState::ReadName() {
  const std::string path = absl::StrCat(path_, "/name");
  std::ifstream(path) >> fleet_name_;
  if (!fleet_name_.empty()) {
    return absl::OkStatus();
  }
  fleet_name_ = absl::StrFormat("%08x", std::random_device()());
  std::ofstream file(path);
  file << fleet_name_ << std::endl;
  return file ? absl::OkStatus()
              : absl::UnavailableError(absl::StrCat(path_, ": cannot write a file"));
}

std::vector<FleetState::Left> FleetState::TakeLeft() {
  std::vector<std::pair<int64_t, std::string>> found;
  int64_t last = 0;
  std::error_code error;
  for (const auto& file : std::filesystem::directory_iterator(path_, error)) {
    const std::string name = file.path().filename();
    absl::string_view digits = name;
    int64_t number = 0;
    if (!absl::ConsumePrefix(&digits, kPoolPrefix)) {
      continue;
    }
    const size_t size = std::min(digits.find_first_not_of("0123456789"), digits.size());
    if (absl::SimpleAtoi(digits.substr(0, size), &number)) {
      last = std::max(last, number);
      if (size == digits.size()) {
        found.emplace_back(number, file.path());
      }
    }
  }
  std::sort(found.begin(), found.end());
  std::vector<Left> left;
  for (const auto& [number, path] : found) {
    absl::StatusOr<JournaledPool> pool = Journal::Read(path);
    if (pool.ok()) {
      left.push_back({path, *std::move(pool)});
      continue;
    }
    if (!absl::IsDataLoss(pool.status())) {
      LogEvent(LogLevel::kError, "pool_resume_failed",
               {{"file", path}, {"message", std::string(pool.status().message())}});
      continue;  // the file stays: another server version, or the next start, can read it
    }
    LogEvent(LogLevel::kError, "journal_quarantined",
             {{"file", path}, {"message", std::string(pool.status().message())}});
    const std::string aside = absl::StrCat(path, ".damaged");
    std::filesystem::rename(path, aside, error);  // first: never read without its log
    std::filesystem::rename(Database::WriteAheadLogOf(path), Database::WriteAheadLogOf(aside),
                            error);
  }
  absl::MutexLock lock(&mutex_);
  last_number_ = std::max(last_number_, last);
  return left;
}

std::string FleetState::NextPath() {
  absl::MutexLock lock(&mutex_);
  return absl::StrCat(path_, "/", kPoolPrefix, ++last_number_);
}

}  // namespace procgen
