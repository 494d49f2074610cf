#include "envcore/games/game_spec.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_join.h"
#include "envcore/world/kinds.h"

namespace procgen {
namespace {

constexpr KindName kCommonKinds[] = {{kAgentKind, "agent"},
                                     {kWallKind, "wall"},
                                     {kExplosionKind, "explosion"},
                                     {kTrailKind, "trail"},
                                     {kEmptyKind, "empty"}};

}  // namespace

absl::Span<const KindName> CommonKindNames() { return kCommonKinds; }

bool GameSpec::HasMode(DistributionMode mode) const {
  if (mode == DistributionMode::kExploration) {
    return exploration_level.has_value();
  }
  return std::find(modes.begin(), modes.end(), mode) != modes.end();
}

// FNV-1a of the name.
uint32_t GameSpec::ArtSeed() const {
  uint32_t hash = 2166136261U;
  for (const char byte : name) {
    hash = (hash ^ static_cast<uint8_t>(byte)) * 16777619U;
  }
  return hash;
}

absl::string_view GameSpec::NameOfKind(int kind) const {
  for (const absl::Span<const KindName> named : {kinds, CommonKindNames()}) {
    for (const KindName& each : named) {
      if (each.kind == kind) {
        return each.name;
      }
    }
  }
  return "";
}

std::optional<int> GameSpec::FindKind(absl::string_view kind_name) const {
  for (const absl::Span<const KindName> named : {kinds, CommonKindNames()}) {
    for (const KindName& each : named) {
      if (each.name == kind_name) {
        return each.kind;
      }
    }
  }
  return std::nullopt;
}

std::string GameSpec::AllKindNames() const {
  std::vector<absl::string_view> names;
  for (const absl::Span<const KindName> named : {CommonKindNames(), kinds}) {
    for (const KindName& each : named) {
      names.push_back(each.name);
    }
  }
  return absl::StrJoin(names, ", ");
}

}  // namespace procgen
