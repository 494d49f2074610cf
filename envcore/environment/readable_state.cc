#include "envcore/environment/readable_state.h"

#include <array>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"
#include "envcore/environment/environment.h"
#include "envcore/games/game_spec.h"
#include "envcore/state/snapshot_frame.h"
#include "envcore/state/snapshot_tree.h"

namespace procgen {
namespace {

using Json = SnapshotTree;

Json NamedKind(const GameSpec& game, int kind) {
  const absl::string_view name = game.NameOfKind(kind);
  return name.empty() ? Json(kind) : Json(std::string(name));
}

Json ReadableEntity(const GameSpec& game, const Json& entity, bool is_agent) {
  Json readable = Json::object();
  const int kind = entity.at("kind").get<int>();
  if (!is_agent) {
    readable["kind"] = NamedKind(game, kind);
  }
  for (const char* const name : {"x", "y", "vx", "vy", "rx", "ry"}) {
    readable[name] = entity.value(name, 0.0);
  }
  for (const auto& field : entity.items()) {
    const bool follows_from_kind = field.key() == "image_kind" && field.value() == kind;
    if (field.key() != "kind" && !follows_from_kind) {
      readable[field.key()] = field.value();
    }
  }
  return readable;
}

Json ReadableGrid(const GameSpec& game, const Grid& grid) {
  Json rows = Json::array();
  for (int y = 0; y < grid.height(); ++y) {
    Json& row = rows.emplace_back(Json::array());
    for (const int16_t kind : grid.Row(y)) {
      row.push_back(NamedKind(game, kind));
    }
  }
  return rows;
}

// The 64-bit float with the fewest digits that is rounded to `value`.
double Shortened(double value) {
  const auto number = static_cast<float>(value);
  std::array<char, 32> text = {};
  std::to_chars(text.data(), text.data() + text.size() - 1, number);
  const double shortened = std::strtod(text.data(), nullptr);
  return static_cast<float>(shortened) == number ? shortened : value;
}

// NOLINTNEXTLINE(misc-no-recursion): as deep as a snapshot
void ShortenFloats(Json* node) {
  if (node->is_number_float()) {
    *node = Shortened(node->get<double>());
  } else if (node->is_structured()) {
    for (Json& child : *node) {
      ShortenFloats(&child);
    }
  }
}

// A field, an entity or a row of the grid in each line.
std::string Text(const Json& json) {
  std::string text = "{";
  absl::string_view separator = "\n";
  for (const auto& [name, value] : json.items()) {
    absl::StrAppend(&text, separator, "\"", name, "\": ");
    separator = ",\n";
    if (!value.is_array() || value.empty()) {
      absl::StrAppend(&text, value.dump());
      continue;
    }
    absl::string_view item_separator = "[\n";
    for (const Json& item : value) {
      absl::StrAppend(&text, item_separator, item.dump());
      item_separator = ",\n";
    }
    absl::StrAppend(&text, "]");
  }
  return absl::StrCat(text, "\n}");
}

}  // namespace

StatusOr<std::string> SnapshotToJson(absl::string_view snapshot) {
  const auto environment = Environment::RestoreAny(snapshot);
  if (!environment.ok()) {
    return environment.status();
  }
  const StatusOr<std::string> saved = (*environment)->SaveState();
  if (!saved.ok()) {
    return saved.status();
  }
  StatusOr<Json> tree = ParseSnapshot(*saved);
  if (!tree.ok()) {
    return tree.status();
  }
  const GameSpec& game = (*environment)->spec();
  Json& world = tree->at("level").at("world");
  Json json = {{"game", std::string(game.name)},
               {"level_seed", tree->at("level_seed")},
               {"edited", (*environment)->edited()},
               {"checksum", SnapshotChecksum(*saved)}};
  Json entities = Json::array();
  for (const Json& entity : world.at("entities")) {
    if (!json.contains("agent")) {
      json["agent"] = ReadableEntity(game, entity, /*is_agent=*/true);
    } else {
      entities.push_back(ReadableEntity(game, entity, /*is_agent=*/false));
    }
  }
  json["entities"] = std::move(entities);
  world.erase("entities");
  world.erase("cells");
  for (const auto& [name, value] : tree->items()) {
    if (!json.contains(name)) {
      json[name] = value;
    }
  }
  ShortenFloats(&json);
  json["grid"] = ReadableGrid(game, (*environment)->game().world().grid);
  return Text(json);
}

}  // namespace procgen
