#include "clients/libenv/make_options.h"

#include <cstring>
#include <limits>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"

namespace procgen {
namespace {

constexpr int32_t kInt32Max = std::numeric_limits<int32_t>::max();
constexpr int32_t kInt32Min = std::numeric_limits<int32_t>::min();
// Maximum length of a string option, in bytes.
constexpr int kStringBytesMax = 1 << 16;

// Reads options by name, keeps the first error, and reports options that were not read.
class OptionReader {
 public:
  explicit OptionReader(const LibenvOptions& options) {
    if (options.count < 0 || (options.count > 0 && options.items == nullptr)) {
      Fail(absl::StrCat("options has count ", options.count, " and ",
                        options.items == nullptr ? "no items" : "items"));
      return;
    }
    for (const LibenvOption& option :
         absl::MakeConstSpan(options.items, static_cast<size_t>(options.count))) {
      if (std::memchr(option.name, '\0', sizeof(option.name)) == nullptr) {
        Fail("an option's name has no terminating zero");
      } else if (!unread_.emplace(option.name, &option).second) {
        Fail(absl::StrCat("option ", option.name, " is given twice"));
      }
    }
  }

  // Each returns whether the option is present, and leaves `value` unchanged otherwise.
  bool ReadInteger(absl::string_view name, int64_t least, int64_t greatest, int32_t* value) {
    const LibenvOption* option = Take(name, kLibenvInt32, "one int32");
    if (option == nullptr) {
      return false;
    }
    int32_t given = 0;
    std::memcpy(&given, option->data, sizeof(given));
    if (given < least || given > greatest) {
      Fail(absl::StrCat("option ", name, " is ", given, ", allowed: ", least, " to ", greatest));
    }
    *value = given;
    return true;
  }

  bool ReadBoolean(absl::string_view name, bool* value) {
    const LibenvOption* option = Take(name, kLibenvUint8, "one uint8, 0 or 1");
    if (option == nullptr) {
      return false;
    }
    const auto given = *static_cast<const uint8_t*>(option->data);
    if (given > 1) {
      Fail(absl::StrCat("option ", name, " is ", given, ", allowed: 0 and 1"));
    }
    *value = given != 0;
    return true;
  }

  bool ReadString(absl::string_view name, std::string* value) {
    const LibenvOption* option = Take(name, kLibenvUint8, "a string of uint8");
    if (option == nullptr) {
      return false;
    }
    value->assign(static_cast<const char*>(option->data), static_cast<size_t>(option->count));
    return true;
  }

  void Require(absl::string_view name, bool given) {
    if (!given) {
      Fail(absl::StrCat("option ", name, " is missing; it is required"));
    }
  }

  // OK if every option was read without an error.
  absl::Status Finish() {
    if (!unread_.empty()) {
      Fail(absl::StrCat("option ", unread_.begin()->first, " is unknown"));
    }
    return status_;
  }

 private:
  void Fail(const std::string& message) {
    if (status_.ok()) {
      status_ = absl::InvalidArgumentError(message);
    }
  }

  // Takes an option from the unread ones; null if it is missing or not as `wanted`.
  const LibenvOption* Take(absl::string_view name, LibenvValueType type, absl::string_view wanted) {
    const auto found = unread_.find(std::string(name));
    if (found == unread_.end()) {
      return nullptr;
    }
    const LibenvOption* option = found->second;
    unread_.erase(found);
    const bool is_string = wanted[0] == 'a';
    const bool count_fits =
        is_string ? option->count >= 0 && option->count <= kStringBytesMax : option->count == 1;
    if (option->value_type != type || !count_fits ||
        (option->data == nullptr && option->count != 0)) {
      Fail(absl::StrCat("option ", name, " has type ", option->value_type, " and count ",
                        option->count, ", must be ", wanted));
      return nullptr;
    }
    return option;
  }

  std::map<std::string, const LibenvOption*> unread_;
  absl::Status status_;
};

// Options of levels and observations.
void ReadEnvironmentOptions(OptionReader& reader, EnvironmentOptions* options) {
  int32_t mode = 0;
  reader.ReadInteger("distribution_mode", kInt32Min, kInt32Max, &mode);
  options->distribution_mode = static_cast<DistributionMode>(mode);
  reader.ReadInteger("num_levels", 0, kInt32Max, &options->num_levels);
  reader.Require("start_level",
                 reader.ReadInteger("start_level", 0, kInt32Max, &options->start_level));
  int32_t rand_seed = 0;
  reader.ReadInteger("rand_seed", kInt32Min, kInt32Max, &rand_seed);
  options->rand_seed = rand_seed;
  reader.ReadInteger("debug_mode", kInt32Min, kInt32Max, &options->debug_mode);
  options->center_agent = false;
  reader.ReadBoolean("center_agent", &options->center_agent);
  reader.ReadBoolean("use_sequential_levels", &options->use_sequential_levels);
  reader.ReadBoolean("use_backgrounds", &options->use_backgrounds);
  reader.ReadBoolean("use_generated_assets", &options->use_generated_assets);
  reader.ReadBoolean("use_monochrome_assets", &options->use_monochrome_assets);
  reader.ReadBoolean("restrict_themes", &options->restrict_themes);
  reader.ReadBoolean("paint_vel_info", &options->paint_vel_info);
}

// Options without effect, of a game that is not part of the suite.
void ReadIdleOptions(OptionReader& reader) {
  int32_t number = 0;
  for (const char* name : {"plain_assets", "physics_mode", "game_type"}) {
    reader.ReadInteger(name, kInt32Min, kInt32Max, &number);
  }
  bool flag = false;
  reader.ReadBoolean("use_easy_jump", &flag);
}

absl::Status CheckMode(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
    case DistributionMode::kHard:
    case DistributionMode::kExtreme:
    case DistributionMode::kMemory:
      return absl::OkStatus();
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("option distribution_mode is ", static_cast<int32_t>(mode),
                       ", allowed: 0 (easy), 1 (hard), 2 (extreme), 10 (memory)"));
  }
}

}  // namespace

absl::StatusOr<MakeOptions> ReadOptions(int env_count, const LibenvOptions& options) {
  if (env_count < 1 || env_count > kLibenvEnvCountMax) {
    return absl::InvalidArgumentError(
        absl::StrCat("env_count is ", env_count, ", allowed: 1 to ", kLibenvEnvCountMax));
  }
  MakeOptions made;
  made.pool.env_count = env_count;
  OptionReader reader(options);
  std::string games;
  reader.Require("env_name", reader.ReadString("env_name", &games));
  made.pool.games = absl::StrSplit(games, ',');
  reader.Require("num_actions",
                 reader.ReadInteger("num_actions", 1, kActionCount, &made.num_actions));
  reader.ReadInteger("num_threads", 0, kLibenvThreadCountMax, &made.num_threads);
  reader.ReadBoolean("render_human", &made.render_human);
  reader.ReadString("resource_root", &made.resource_root);
  ReadEnvironmentOptions(reader, &made.pool.environment);
  ReadIdleOptions(reader);
  absl::Status status = reader.Finish();
  status.Update(CheckMode(made.pool.environment.distribution_mode));
  if (!status.ok()) {
    return status;
  }
  return made;
}

}  // namespace procgen
