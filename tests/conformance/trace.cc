#include "tests/conformance/trace.h"

#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "envcore/games/game_catalog.h"
#include "nlohmann/json.hpp"

namespace procgen {
namespace {

constexpr char kFormat[] = "procgen-trace-1";
constexpr uint8_t kEndEpisodeByte = 255;
constexpr int32_t kValueCountMax = 1 << 28;  // of one array; more is no recording

using Json = nlohmann::json;

struct Array {
  std::string type;
  std::string bytes;
};

template <typename T>
std::vector<T> ValuesOf(const Array& array) {
  std::vector<T> values(array.bytes.size() / sizeof(T));
  std::memcpy(values.data(), array.bytes.data(), values.size() * sizeof(T));
  return values;
}

size_t SizeOfType(const std::string& type) {
  return type == "u1" ? 1 : (type == "i4" || type == "u4" || type == "f4") ? 4 : 0;
}

EnvironmentOptions OptionsOf(const Json& header) {
  const Json& json = header.at("options");
  EnvironmentOptions options;
  const auto mode_name = json.at("distribution_mode").get<std::string>();
  const auto mode = FindDistributionMode(mode_name);
  if (!mode.has_value()) {
    throw std::invalid_argument(absl::StrCat("no distribution mode is named \"", mode_name, "\""));
  }
  options.distribution_mode = *mode;
  options.num_levels = json.at("num_levels").get<int32_t>();
  options.start_level = json.at("start_level").get<int32_t>();
  options.rand_seed = json.at("rand_seed").get<int64_t>();
  options.use_sequential_levels = json.at("use_sequential_levels").get<bool>();
  options.center_agent = json.at("center_agent").get<bool>();
  options.use_backgrounds = json.at("use_backgrounds").get<bool>();
  options.use_generated_assets = json.at("use_generated_assets").get<bool>();
  options.use_monochrome_assets = json.at("use_monochrome_assets").get<bool>();
  options.restrict_themes = json.at("restrict_themes").get<bool>();
  options.paint_vel_info = json.at("paint_vel_info").get<bool>();
  options.debug_mode = json.at("debug_mode").get<int32_t>();
  return options;
}

absl::StatusOr<std::map<std::string, Array>> ReadArrays(const Json& header, int32_t env_count,
                                                        std::istream& file) {
  std::map<std::string, Array> arrays;
  for (const Json& entry : header.at("arrays")) {
    const auto name = entry.at(0).get<std::string>();
    Array& array = arrays[name];
    array.type = entry.at(1).get<std::string>();
    const auto rows = entry.at(2).get<int64_t>();
    const size_t value_size = SizeOfType(array.type);
    if (value_size == 0 || rows < 0 || rows > kValueCountMax / env_count) {
      return absl::DataLossError(absl::StrCat("array ", name, " has type ", array.type, " and ",
                                              rows, " rows of ", env_count));
    }
    array.bytes.resize(static_cast<size_t>(rows * env_count) * value_size);
    file.read(array.bytes.data(), static_cast<std::streamsize>(array.bytes.size()));
    if (!file) {
      return absl::DataLossError(absl::StrCat("the file ends within array ", name));
    }
  }
  return arrays;
}

absl::StatusOr<Trace> ReadTraceAfterHeader(const Json& header, std::istream& file) {
  if (header.at("format") != kFormat) {
    return absl::DataLossError(
        absl::StrCat("format is ", header.at("format").dump(), ", must be ", kFormat));
  }
  Trace trace;
  trace.games = absl::StrSplit(header.at("options").at("env_name").get<std::string>(), ',');
  trace.options = OptionsOf(header);
  trace.env_count = header.at("num_envs").get<int32_t>();
  trace.step_count = header.at("steps").get<int32_t>();
  if (trace.env_count < 1) {
    return absl::DataLossError(
        absl::StrCat("num_envs is ", trace.env_count, ", must be at least 1"));
  }
  if (trace.step_count < 0) {
    return absl::DataLossError(absl::StrCat("steps is ", trace.step_count, ", must be at least 0"));
  }
  auto arrays = ReadArrays(header, trace.env_count, file);
  if (!arrays.ok()) {
    return arrays.status();
  }
  for (const uint8_t action : ValuesOf<uint8_t>(arrays->at("action"))) {
    trace.actions.push_back(action == kEndEpisodeByte ? kEndEpisodeAction : action);
  }
  trace.rewards = ValuesOf<float>(arrays->at("reward"));
  trace.first = ValuesOf<uint8_t>(arrays->at("first"));
  trace.level_seeds = ValuesOf<int32_t>(arrays->at("level_seed"));
  trace.prev_level_seeds = ValuesOf<int32_t>(arrays->at("prev_level_seed"));
  trace.prev_level_complete = ValuesOf<uint8_t>(arrays->at("prev_level_complete"));
  if (const auto found = arrays->find("observation_fnv1a"); found != arrays->end()) {
    trace.observation_digests = ValuesOf<uint32_t>(found->second);
  }
  const auto row = static_cast<size_t>(trace.env_count);
  const size_t steps = static_cast<size_t>(trace.step_count) * row;
  if (trace.actions.size() != steps || trace.rewards.size() != steps + row ||
      trace.first.size() != steps + row || trace.level_seeds.size() != steps + row ||
      trace.prev_level_seeds.size() != steps + row ||
      trace.prev_level_complete.size() != steps + row ||
      (!trace.observation_digests.empty() && trace.observation_digests.size() != steps + row)) {
    return absl::DataLossError("an array has another number of rows than steps say");
  }
  return trace;
}

}  // namespace

absl::StatusOr<Trace> ReadTrace(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return absl::NotFoundError(absl::StrCat("cannot open ", path));
  }
  std::string line;
  std::getline(file, line);
  // The library reports what a document lacks by exceptions; none leaves this function.
  try {
    return ReadTraceAfterHeader(Json::parse(line), file);
  } catch (const std::exception& error) {
    return absl::DataLossError(absl::StrCat("the header is not a trace's: ", error.what()));
  }
}

uint32_t ObservationDigest(const uint8_t* bytes, size_t size) {
  uint32_t hash = 0x811c9dc5U;
  for (size_t i = 0; i < size; ++i) {
    hash = (hash ^ bytes[i]) * 16777619U;
  }
  return hash;
}

}  // namespace procgen
