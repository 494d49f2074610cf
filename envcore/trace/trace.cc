#include "envcore/trace/trace.h"

#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "envcore/environment/environment_options.h"
#include "envcore/games/game_catalog.h"
#include "envcore/games/game_variants.h"
#include "envcore/status/status.h"
#include "nlohmann/json.hpp"

namespace procgen {
namespace {

constexpr char kFormat[] = "procgen-trace-1";
constexpr uint8_t kEndEpisodeByte = 255;
constexpr size_t kFingerprintDigits = 16;

using Json = nlohmann::ordered_json;

struct Array {
  std::string type;
  absl::string_view bytes;
};
using Arrays = std::map<std::string, Array>;

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
  const Status status = RequireVariant(json.value("variant", std::string()), &options);
  if (!status.ok()) {
    throw std::invalid_argument(std::string(status.message()));
  }
  return options;
}

StatusOr<Arrays> ReadArrays(const Json& header, int32_t env_count, absl::string_view rest) {
  Arrays arrays;
  for (const Json& entry : header.at("arrays")) {
    const auto name = entry.at(0).get<std::string>();
    Array& array = arrays[name];
    array.type = entry.at(1).get<std::string>();
    const auto rows = entry.at(2).get<int64_t>();
    const size_t value_size = SizeOfType(array.type);
    if (value_size == 0 || rows < 0) {
      return DataLossError(absl::StrCat("array ", name, " has type ", array.type, " and ", rows,
                                        " rows of ", env_count));
    }
    const size_t row_size = static_cast<size_t>(env_count) * value_size;
    if (static_cast<size_t>(rows) > rest.size() / row_size) {
      return DataLossError(absl::StrCat("the file ends within array ", name, ", which has ", rows,
                                        " rows of ", env_count));
    }
    array.bytes = rest.substr(0, static_cast<size_t>(rows) * row_size);
    rest.remove_prefix(array.bytes.size());
  }
  return arrays;
}

// Returns the values of a required array. Throws if it is missing or has another type.
template <typename T>
std::vector<T> ValuesOf(const Arrays& arrays, const std::string& name, absl::string_view type) {
  const auto found = arrays.find(name);
  if (found == arrays.end()) {
    throw std::invalid_argument(absl::StrCat("array ", name, " is missing"));
  }
  if (found->second.type != type) {
    throw std::invalid_argument(
        absl::StrCat("array ", name, " has type ", found->second.type, ", must be ", type));
  }
  std::vector<T> values(found->second.bytes.size() / sizeof(T));
  if (!values.empty()) {
    std::memcpy(values.data(), found->second.bytes.data(), values.size() * sizeof(T));
  }
  return values;
}

std::vector<std::vector<uint64_t>> FingerprintsOf(const Json& header, int32_t env_count) {
  std::vector<std::vector<uint64_t>> fingerprints;
  const auto found = header.find("fingerprints");
  if (found == header.end()) {
    return fingerprints;
  }
  for (const Json& environment : *found) {
    std::vector<uint64_t>& list = fingerprints.emplace_back();
    for (const Json& digits : environment) {
      const auto text = digits.get<std::string>();
      uint64_t& value = list.emplace_back();
      if (text.size() != kFingerprintDigits || !absl::SimpleHexAtoi(text, &value)) {
        throw std::invalid_argument(absl::StrCat("\"", text, "\" is not a fingerprint"));
      }
    }
  }
  if (fingerprints.size() != static_cast<size_t>(env_count)) {
    throw std::invalid_argument(
        absl::StrCat("fingerprints has ", fingerprints.size(), " lists, must have ", env_count));
  }
  return fingerprints;
}

Status CheckRows(const Trace& trace) {
  const auto row = static_cast<size_t>(trace.env_count);
  const size_t steps = static_cast<size_t>(trace.step_count) * row;
  if (trace.actions.size() != steps || trace.rewards.size() != steps + row ||
      trace.first.size() != steps + row || trace.level_seeds.size() != steps + row ||
      trace.prev_level_seeds.size() != steps + row ||
      trace.prev_level_complete.size() != steps + row ||
      (!trace.observation_digests.empty() && trace.observation_digests.size() != steps + row)) {
    return DataLossError("an array has the wrong number of rows for steps and num_envs");
  }
  return OkStatus();
}

StatusOr<Trace> ParseAfterHeader(const Json& header, absl::string_view rest) {
  if (header.at("format") != kFormat) {
    return DataLossError(
        absl::StrCat("format is ", header.at("format").dump(), ", must be ", kFormat));
  }
  Trace trace;
  trace.games = absl::StrSplit(header.at("options").at("env_name").get<std::string>(), ',');
  trace.options = OptionsOf(header);
  trace.env_count = header.at("num_envs").get<int32_t>();
  trace.step_count = header.at("steps").get<int32_t>();
  if (trace.env_count < 1) {
    return DataLossError(absl::StrCat("num_envs is ", trace.env_count, ", must be at least 1"));
  }
  if (trace.step_count < 0) {
    return DataLossError(absl::StrCat("steps is ", trace.step_count, ", must be at least 0"));
  }
  const StatusOr<Arrays> arrays = ReadArrays(header, trace.env_count, rest);
  if (!arrays.ok()) {
    return arrays.status();
  }
  for (const uint8_t action : ValuesOf<uint8_t>(*arrays, "action", "u1")) {
    trace.actions.push_back(action == kEndEpisodeByte ? kEndEpisodeAction : action);
  }
  trace.rewards = ValuesOf<float>(*arrays, "reward", "f4");
  trace.first = ValuesOf<uint8_t>(*arrays, "first", "u1");
  trace.level_seeds = ValuesOf<int32_t>(*arrays, "level_seed", "i4");
  trace.prev_level_seeds = ValuesOf<int32_t>(*arrays, "prev_level_seed", "i4");
  trace.prev_level_complete = ValuesOf<uint8_t>(*arrays, "prev_level_complete", "u1");
  if (arrays->contains("observation_fnv1a")) {
    trace.observation_digests = ValuesOf<uint32_t>(*arrays, "observation_fnv1a", "u4");
  }
  trace.fingerprints = FingerprintsOf(header, trace.env_count);
  if (Status status = CheckRows(trace); !status.ok()) {
    return status;
  }
  return trace;
}

// Appends an array to the list in the header and to the bytes after it.
template <typename T>
void AddArray(const char* name, const char* type, const Trace& trace, const std::vector<T>& values,
              Json* list, std::string* bytes) {
  list->push_back({name, type, values.size() / static_cast<size_t>(trace.env_count)});
  if (!values.empty()) {
    bytes->append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
}

Json OptionsJsonOf(const Trace& trace) {
  const EnvironmentOptions& options = trace.options;
  Json json = {{"env_name", absl::StrJoin(trace.games, ",")},
               {"distribution_mode", std::string(DistributionModeName(options.distribution_mode))},
               {"num_levels", options.num_levels},
               {"start_level", options.start_level},
               {"rand_seed", options.rand_seed},
               {"use_sequential_levels", options.use_sequential_levels},
               {"center_agent", options.center_agent},
               {"use_backgrounds", options.use_backgrounds},
               {"restrict_themes", options.restrict_themes},
               {"use_monochrome_assets", options.use_monochrome_assets},
               {"use_generated_assets", options.use_generated_assets},
               {"paint_vel_info", options.paint_vel_info},
               {"debug_mode", options.debug_mode}};
  if (options.variant != Variant::kNone) {
    json["variant"] = VariantText(options.variant, options.variant_value);
  }
  return json;
}

Json FingerprintsJsonOf(const Trace& trace) {
  Json environments = Json::array();
  for (const std::vector<uint64_t>& list : trace.fingerprints) {
    Json& texts = environments.emplace_back(Json::array());
    for (const uint64_t value : list) {
      texts.push_back(absl::StrCat(absl::Hex(value, absl::kZeroPad16)));
    }
  }
  return environments;
}

}  // namespace

StatusOr<Trace> ReadTrace(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return NotFoundError(absl::StrCat("cannot open ", path));
  }
  const std::string contents((std::istreambuf_iterator<char>(file)),
                             std::istreambuf_iterator<char>());
  return ParseTrace(contents);
}

StatusOr<Trace> ParseTrace(absl::string_view contents) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(contents, absl::MaxSplits('\n', 1));
  // The JSON library reports missing fields by exceptions; none leaves this function.
  try {
    return ParseAfterHeader(Json::parse(parts.first), parts.second);
  } catch (const Json::parse_error&) {
    return DataLossError("invalid trace header: the first line is not JSON");
  } catch (const Json::exception& error) {
    // Its texts begin with "[json.exception.KIND.NUMBER] ".
    const std::pair<absl::string_view, absl::string_view> text =
        absl::StrSplit(error.what(), absl::MaxSplits("] ", 1));
    return DataLossError(absl::StrCat("invalid trace header: ", text.second));
  } catch (const std::exception& error) {
    return DataLossError(absl::StrCat("invalid trace header: ", error.what()));
  }
}

std::string TraceFileOf(const Trace& trace) {
  Json list = Json::array();
  std::string bytes;
  std::vector<uint8_t> actions;
  actions.reserve(trace.actions.size());
  for (const int32_t action : trace.actions) {
    actions.push_back(action == kEndEpisodeAction ? kEndEpisodeByte : static_cast<uint8_t>(action));
  }
  AddArray("action", "u1", trace, actions, &list, &bytes);
  AddArray("reward", "f4", trace, trace.rewards, &list, &bytes);
  AddArray("first", "u1", trace, trace.first, &list, &bytes);
  AddArray("level_seed", "i4", trace, trace.level_seeds, &list, &bytes);
  AddArray("prev_level_seed", "i4", trace, trace.prev_level_seeds, &list, &bytes);
  AddArray("prev_level_complete", "u1", trace, trace.prev_level_complete, &list, &bytes);
  if (!trace.observation_digests.empty()) {
    AddArray("observation_fnv1a", "u4", trace, trace.observation_digests, &list, &bytes);
  }
  Json header = {{"format", kFormat},
                 {"options", OptionsJsonOf(trace)},
                 {"num_envs", trace.env_count},
                 {"steps", trace.step_count},
                 {"arrays", std::move(list)}};
  if (!trace.fingerprints.empty()) {
    header["fingerprints"] = FingerprintsJsonOf(trace);
  }
  return absl::StrCat(header.dump(), "\n", bytes);
}

uint32_t ObservationDigest(const uint8_t* bytes, size_t size) {
  uint32_t hash = 0x811c9dc5U;
  for (size_t i = 0; i < size; ++i) {
    hash = (hash ^ bytes[i]) * 16777619U;
  }
  return hash;
}

}  // namespace procgen
