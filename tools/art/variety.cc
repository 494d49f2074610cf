#include "tools/art/variety.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "envcore/environment/environment_options.h"
#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "envcore/render/scene/rasteriser.h"
#include "envcore/scene/scene.h"
#include "tools/art/lab_color.h"

namespace procgen {
namespace {

constexpr int32_t kLevelCount = 1000;

// The mean and the standard deviation of one value of all views.
std::pair<double, double> MeanAndDeviation(absl::Span<const ViewColors> views,
                                           double ViewColors::*value) {
  double sum = 0;
  double squares = 0;
  for (const ViewColors& view : views) {
    sum += view.*value;
    squares += view.*value * (view.*value);
  }
  const auto count = static_cast<double>(views.size());
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

double HueSpread(absl::Span<const ViewColors> views) {
  double cos = 0;
  double sin = 0;
  for (const ViewColors& view : views) {
    const double hue = std::atan2(view.b, view.a);
    cos += std::cos(hue);
    sin += std::sin(hue);
  }
  const double length = std::hypot(cos, sin) / static_cast<double>(views.size());
  return std::sqrt(std::max(0.0, -2 * std::log(std::max(length, 1e-9)))) * 180 / std::numbers::pi;
}

}  // namespace

ViewColors ColorsOf(absl::Span<const uint8_t> rgb, int side_px) {
  ViewColors colors;
  double squares = 0;
  const auto side = static_cast<size_t>(side_px);
  const auto pixel_count = static_cast<double>(side * side);
  const auto neighbor_count = static_cast<double>(side * (side - 1));
  double left = 0;
  for (size_t i = 0; i < side * side; ++i) {
    const LabColor lab = ToLab({rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 255});
    const double lightness = lab.lightness;
    colors.lightness += lightness / pixel_count;
    squares += lightness * lightness / pixel_count;
    colors.chroma += std::hypot(lab.a, lab.b) / pixel_count;
    colors.a += lab.a / pixel_count;
    colors.b += lab.b / pixel_count;
    colors.grain += i % side == 0 ? 0 : std::abs(lightness - left) / neighbor_count;
    left = lightness;
  }
  colors.contrast = std::sqrt(std::max(0.0, squares - colors.lightness * colors.lightness));
  return colors;
}

Variety SpreadOf(absl::Span<const ViewColors> views) {
  Variety variety;
  std::tie(variety.lightness, variety.lightness_spread) =
      MeanAndDeviation(views, &ViewColors::lightness);
  std::tie(variety.contrast, variety.contrast_spread) =
      MeanAndDeviation(views, &ViewColors::contrast);
  std::tie(variety.chroma, variety.chroma_spread) = MeanAndDeviation(views, &ViewColors::chroma);
  variety.hue_spread = HueSpread(views);
  variety.color_spread =
      std::hypot(variety.lightness_spread, MeanAndDeviation(views, &ViewColors::a).second,
                 MeanAndDeviation(views, &ViewColors::b).second);
  variety.grain = MeanAndDeviation(views, &ViewColors::grain).first;
  return variety;
}

Variety MeasureVariety(const Roles& roles, const SharedArt& art) {
  const GameSpec& spec = *FindGame(roles.game);
  EnvironmentOptions options;
  options.distribution_mode = roles.mode;
  const std::unique_ptr<Game> game = spec.make(ResolveOptions(spec.name, options).value());
  const auto game_art = art.Of(spec, game->art());
  Rasteriser rasteriser;
  std::vector<ViewColors> views;
  std::array<uint8_t, kUpstreamFrameFormat.bytes()> rgb = {};
  for (int32_t level = 0; level < kLevelCount; ++level) {
    game->StartLevel(level);
    Scene scene;
    game->FillScene(&scene);
    rasteriser.DrawAgentView(scene, *game_art, nullptr, kUpstreamFrameFormat, absl::MakeSpan(rgb));
    views.push_back(ColorsOf(rgb, kUpstreamFrameFormat.size_px));
  }
  return SpreadOf(views);
}

}  // namespace procgen
