// SnapshotFromJson.

#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "envcore/environment/environment.h"
#include "envcore/environment/readable_state.h"
#include "envcore/games/game_spec.h"
#include "envcore/state/snapshot_frame.h"
#include "envcore/state/snapshot_tree.h"
#include "envcore/world/kinds.h"

namespace procgen {
namespace {

using Json = SnapshotTree;
using Floats = StateArchive::Floats;

constexpr size_t kJsonBytesMax = size_t{1} << 24;
constexpr int64_t kKindMax = 1100;  // as in snapshots
constexpr int kJsonDepthMax = 8;    // as that of a snapshot

// A message about the fields of a snapshot as one about those of the JSON.
std::string ReadableMessage(absl::string_view message) {
  constexpr absl::string_view kEntity = "level.world.entities[";
  const size_t begin = message.find(kEntity);
  int32_t index = 0;
  if (begin != absl::string_view::npos) {
    const size_t digits = begin + kEntity.size();
    const size_t end = message.find(']', digits);
    if (absl::SimpleAtoi(message.substr(digits, end - digits), &index)) {
      return absl::StrCat(message.substr(0, begin),
                          index == 0 ? "agent" : absl::StrCat("entities[", index - 1, "]"),
                          message.substr(end + 1));
    }
  }
  return absl::StrReplaceAll(
      message,
      {{"level.world.entities", "agent and entities"},
       {"the snapshot has the unknown field", "the state has the unknown field"},
       {"; its fields are game,", "; its fields are checksum, agent, entities, grid, game,"}});
}

Status Invalid(const Status& status) {
  return InvalidArgumentError(ReadableMessage(status.message()));
}

// Removes a field and returns it. Errors: it is missing or of another type.
StatusOr<Json> Taken(Json* json, const char* name, Json::value_t type,
                     absl::string_view type_name) {
  const auto found = json->find(name);
  if (found == json->end() || found->type() != type) {
    return InvalidArgumentError(absl::StrCat(
        name, found == json->end() ? " is missing, must be " : " must be ", type_name));
  }
  Json value = std::move(*found);
  json->erase(found);
  return value;
}

StatusOr<int> KindOf(const GameSpec& game, const Json& named, const std::string& path) {
  if (named.is_number_integer()) {
    const auto number = named.get<int64_t>();  // negative if it is beyond 63 bits
    if (number < 0 || number > kKindMax) {
      return InvalidArgumentError(
          absl::StrCat(path, " is ", named.dump(), ", must be a name or in [0, ", kKindMax, "]"));
    }
    return static_cast<int>(number);
  }
  const std::optional<int> kind =
      named.is_string() ? game.FindKind(named.get_ref<const std::string&>()) : std::nullopt;
  if (!kind.has_value()) {
    return InvalidArgumentError(
        absl::StrCat(path, " is ", named.dump(), ", ", game.name, " has ", game.AllKindNames()));
  }
  return *kind;
}

// Completes the fields of an entity that follow from its kind.
Status AddKind(const GameSpec& game, const std::string& path, Json* entity) {
  if (!entity->is_object()) {
    return InvalidArgumentError(absl::StrCat(path, " is not a group of fields"));
  }
  const auto named = entity->find("kind");
  if (named == entity->end()) {
    return InvalidArgumentError(absl::StrCat(path, ".kind is missing"));
  }
  const StatusOr<int> kind = KindOf(game, *named, absl::StrCat(path, ".kind"));
  if (!kind.ok()) {
    return kind.status();
  }
  (*entity)["kind"] = *kind;
  if (!entity->contains("image_kind")) {
    (*entity)["image_kind"] = *kind;
  }
  return OkStatus();
}

StatusOr<Json> AllEntities(const GameSpec& game, Json agent, Json entities) {
  if (agent.contains("kind")) {
    return InvalidArgumentError("agent has the field kind, which is only for entities");
  }
  agent["kind"] = kAgentKind;
  Json all = Json::array();
  all.push_back(std::move(agent));
  for (Json& entity : entities) {
    all.push_back(std::move(entity));
  }
  for (size_t i = 0; i < all.size(); ++i) {
    const std::string path = i == 0 ? "agent" : absl::StrCat("entities[", i - 1, "]");
    if (Status status = AddKind(game, path, &all[i]); !status.ok()) {
      return status;
    }
  }
  return all;
}

// The cells as runs: kind, count, kind, count ...
StatusOr<Json> RunsOf(const GameSpec& game, const Json& rows, const Grid& level) {
  if (rows.size() != static_cast<size_t>(level.height())) {
    return InvalidArgumentError(
        absl::StrCat("grid has ", rows.size(), " rows, the level has ", level.height()));
  }
  Json runs = Json::array();
  for (size_t y = 0; y < rows.size(); ++y) {
    const size_t width = rows[y].is_array() ? rows[y].size() : 0;
    if (width != static_cast<size_t>(level.width())) {
      return InvalidArgumentError(absl::StrCat("grid[", y, "] has ", width, " cells, the level is ",
                                               level.width(), " wide"));
    }
    for (size_t x = 0; x < width; ++x) {
      const StatusOr<int> kind = KindOf(game, rows[y][x], absl::StrCat("grid[", y, "][", x, "]"));
      if (!kind.ok()) {
        return kind.status();
      }
      if (runs.empty() || runs[runs.size() - 2] != *kind) {
        runs.push_back(*kind);
        runs.push_back(0);
      }
      runs.back() = runs.back().get<int>() + 1;
    }
  }
  return runs;
}

// The grid of the level that a state names, as it was at its start.
StatusOr<Grid> GridAtStart(const GameSpec& spec, const Json& tree) {
  const auto episode = ReadSavedMoment(SerializeSnapshot(tree), Floats::kRounded);
  if (!episode.ok()) {
    return Invalid(episode.status());
  }
  const auto options = ResolveOptions(spec.name, episode->options);
  if (!options.ok()) {
    return InvalidArgumentError(absl::StrCat("options: ", options.status().message()));
  }
  const std::unique_ptr<Game> game = spec.make(*options);
  game->StartLevel(episode->level_seed);
  return game->world().grid;
}

StatusOr<Json> ParsedJson(absl::string_view text) {
  if (text.size() > kJsonBytesMax) {
    return InvalidArgumentError(
        absl::StrCat("the text has ", text.size(), " bytes, at most ", kJsonBytesMax));
  }
  try {
    Json json = Json::parse(text.begin(), text.end(), [](int depth, auto&&...) {
      return depth <= kJsonDepthMax ? true : throw std::length_error("it is nested too deep");
    });
    if (json.is_object()) {
      return json;
    }
  } catch (const std::exception& error) {
    return InvalidArgumentError(absl::StrCat("the text is not JSON: ", error.what()));
  }
  return InvalidArgumentError("the text is not a JSON object");
}

// The fields of a snapshot from those of the JSON.
StatusOr<Json> TreeOf(Json json) {
  const std::string name =
      json.contains("game") && json["game"].is_string() ? json["game"].get<std::string>() : "";
  const StatusOr<const GameSpec*> spec = RequireGame(name);
  if (!spec.ok()) {
    return InvalidArgumentError(absl::StrCat("game: ", spec.status().message()));
  }
  StatusOr<Json> agent = Taken(&json, "agent", Json::value_t::object, "a group of fields");
  StatusOr<Json> entities = Taken(&json, "entities", Json::value_t::array, "a list");
  StatusOr<Json> rows = Taken(&json, "grid", Json::value_t::array, "a list of rows");
  for (const StatusOr<Json>* each : {&agent, &entities, &rows}) {
    if (!each->ok()) {
      return each->status();
    }
  }
  StatusOr<Json> all = AllEntities(**spec, *std::move(agent), *std::move(entities));
  if (!all.ok()) {
    return all.status();
  }
  const StatusOr<Grid> grid = GridAtStart(**spec, json);
  if (!grid.ok()) {
    return grid.status();
  }
  StatusOr<Json> runs = RunsOf(**spec, *rows, *grid);
  if (!runs.ok()) {
    return runs.status();
  }
  if (!json.contains("level") || !json["level"].is_object() || !json["level"].contains("world") ||
      !json["level"]["world"].is_object()) {
    return InvalidArgumentError("level.world is missing, must be a group of fields");
  }
  Json& world = json["level"]["world"];
  world["cells"] = *std::move(runs);
  world["entities"] = *std::move(all);
  return json;
}

// Removes the checksum and returns it; absent if there is none.
StatusOr<std::optional<uint32_t>> TakenChecksum(Json* json) {
  const auto found = json->find("checksum");
  if (found == json->end()) {
    return std::optional<uint32_t>();
  }
  if (!found->is_number_unsigned()) {
    return InvalidArgumentError(
        absl::StrCat("checksum is ", found->dump(), ", must be an integer of at least 0"));
  }
  const auto checksum = static_cast<uint32_t>(found->get<uint64_t>());
  json->erase(found);
  return std::optional<uint32_t>(checksum);
}

}  // namespace

StatusOr<std::string> SnapshotFromJson(absl::string_view text) {
  StatusOr<Json> json = ParsedJson(text);
  if (!json.ok()) {
    return json.status();
  }
  const StatusOr<std::optional<uint32_t>> checksum = TakenChecksum(&*json);
  if (!checksum.ok()) {
    return checksum.status();
  }
  const StatusOr<Json> tree = TreeOf(*std::move(json));
  if (!tree.ok()) {
    return tree.status();
  }
  const auto environment = Environment::RestoreAny(SerializeSnapshot(*tree), Floats::kRounded);
  if (!environment.ok()) {
    return Invalid(environment.status());
  }
  StatusOr<std::string> saved = (*environment)->SaveState();
  if (!saved.ok() || *checksum == SnapshotChecksum(*saved)) {
    return saved;
  }
  if (Status status = (*environment)->MarkEdited(SnapshotChecksum(*saved)); !status.ok()) {
    return status;
  }
  return (*environment)->SaveState();
}

}  // namespace procgen
