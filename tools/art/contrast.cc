#include "tools/art/contrast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <set>

#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "envcore/render/art/game_art.h"
#include "envcore/render/scene/rasteriser.h"
#include "envcore/scene/scene.h"
#include "tools/art/lab_color.h"
#include "tools/art/played_level.h"

namespace procgen {
namespace {

constexpr int32_t kLevelCount = 8;

// The image kinds of a game's figures.
std::set<int> FigureKinds(const Roles& roles) {
  std::set<int> kinds;
  for (const Part& part : roles.parts) {
    if (part.role != Role::kBlocks && part.role != Role::kHarmless) {
      kinds.insert(part.image_kinds.begin(), part.image_kinds.end());
    }
  }
  return kinds;
}

void RemoveFigures(const std::set<int>& kinds, Scene* scene) {
  const auto is_figure = [&](const auto& look) { return kinds.count(look.image_kind) > 0; };
  for (auto* sprites : {&scene->below_cells, &scene->above_cells}) {
    sprites->erase(std::remove_if(sprites->begin(), sprites->end(), is_figure), sprites->end());
  }
  for (CellAppearance& look : scene->cells.looks) {
    if (is_figure(look)) {
      look.image_kind = -1;
    }
  }
  if (kinds.contains(kDotImage)) {
    scene->cells.dots.kind = kOutsideKind;
  }
}

double StandardDeviation(absl::Span<const uint8_t> rgb) {
  constexpr size_t kChannels = 3;
  std::array<double, kChannels> sums = {};
  double squares = 0;
  for (size_t i = 0; i < rgb.size(); ++i) {
    sums[i % kChannels] += rgb[i];
    squares += rgb[i] * rgb[i];
  }
  const double pixels = static_cast<double>(rgb.size()) / kChannels;
  double squared_means = 0;
  for (const double sum : sums) {
    squared_means += sum / pixels * (sum / pixels);
  }
  return std::sqrt(std::max(0.0, (squares / pixels - squared_means) / kChannels));
}

double MeanDifference(absl::Span<const uint8_t> first, absl::Span<const uint8_t> second) {
  double sum = 0;
  int64_t count = 0;
  for (size_t i = 0; i < first.size(); i += 3) {
    const Rgba a = {first[i], first[i + 1], first[i + 2], 255};
    const Rgba b = {second[i], second[i + 1], second[i + 2], 255};
    if (!(a == b)) {
      sum += ColorDifference(ToLab(a), ToLab(b));
      ++count;
    }
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

}  // namespace

Contrast ContrastOf(absl::Span<const uint8_t> rgb, absl::Span<const uint8_t> rgb_bare) {
  return {.view = StandardDeviation(rgb), .figures = MeanDifference(rgb, rgb_bare)};
}

Contrast MeasureContrast(const Roles& roles, const SharedArt& art) {
  const GameSpec& spec = *FindGame(roles.game);
  const std::set<int> figure_kinds = FigureKinds(roles);
  Rasteriser rasteriser;
  Contrast sum;
  for (int32_t level = 0; level < kLevelCount; ++level) {
    const std::unique_ptr<Game> game = PlayedLevel(spec, roles.mode, level);
    const auto game_art = art.Of(spec, game->art());
    const auto draw = [&](const Scene& scene) {
      std::array<uint8_t, kUpstreamFrameFormat.bytes()> view = {};
      rasteriser.DrawAgentView(scene, *game_art, nullptr, kUpstreamFrameFormat,
                               absl::MakeSpan(view));
      return view;
    };
    Scene scene;
    game->FillScene(&scene);
    const auto view = draw(scene);
    RemoveFigures(figure_kinds, &scene);
    const Contrast contrast = ContrastOf(view, draw(scene));
    sum.view += contrast.view;
    sum.figures += contrast.figures;
  }
  return {.view = sum.view / kLevelCount, .figures = sum.figures / kLevelCount};
}

}  // namespace procgen
