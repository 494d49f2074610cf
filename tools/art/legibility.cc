#include "tools/art/legibility.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "envcore/render/art/game_art.h"
#include "envcore/render/art/nearest_sampling.h"
#include "envcore/render/raster/flat_rectangle.h"
#include "envcore/render/scene/rasteriser.h"
#include "envcore/scene/scene.h"
#include "tools/art/backdrops.h"
#include "tools/art/lab_color.h"

namespace procgen {
namespace {

constexpr size_t kPixelCount = kWindowSizePx * kWindowSizePx;
// Smallest alpha at which a pixel counts as covered.
constexpr uint8_t kCoveredAlpha = 64;
// A pair has the distance that is exceeded in all but this fraction of the windows of a backdrop.
constexpr double kWorstShare = 0.1;

// One appearance of a part.
struct Look {
  size_t part = 0;
  Appearance appearance;
  std::bitset<kPixelCount> covered;
  // The pixels on one backdrop, for each of its windows.
  std::vector<std::array<LabColor, kPixelCount>> drawn;
};

// Draws the parts of a game.
class PartRenderer {
 public:
  PartRenderer(const Roles& roles, const Game& stage, const GameArt& art)
      : roles_(roles), art_(art) {
    stage.FillScene(&scene_);
    pixels_per_cell_ = kUpstreamFrameFormat.size_px / scene_.camera.cells;
  }

  // Draws a part at the center of a window.
  void Draw(const Part& part, const Appearance& appearance, Window* window) const {
    const Frame frame = {window->data(), kWindowSizePx};
    if (appearance.image_kind == kDotImage) {
      const CellDots& dots = scene_.cells.dots;
      const double side = dots.share * pixels_per_cell_;
      DrawFlatAliased(Middle(side, side), {dots.color[0], dots.color[1], dots.color[2], 255},
                      frame);
      return;
    }
    const MipmappedImage& picture =
        *art_.SpriteOf(appearance.image_kind, appearance.theme, false).picture;
    double width = part.width * pixels_per_cell_;
    double height = part.height * pixels_per_cell_;
    if (part.keeps_ratio) {
      const Image& image = picture.level(0);
      const double scale = std::min(width / image.width(), height / image.height());
      width = image.width() * scale;
      height = image.height() * scale;
    }
    DrawNearest(picture, Middle(width, height), 0, 1, frame);
  }

  // All looks of the parts, not drawn on any backdrop yet.
  std::vector<Look> Looks(const Game& stage) const {
    std::vector<Look> looks;
    for (size_t i = 0; i < roles_.parts.size(); ++i) {
      const Part& part = roles_.parts[i];
      for (const int kind : part.image_kinds) {
        const int last = std::min(part.last_theme, ThemeCountOf(stage, kind) - 1);
        for (int theme = part.first_theme; theme <= last; ++theme) {
          Look& look = looks.emplace_back();
          look.part = i;
          look.appearance = {.image_kind = kind, .theme = theme};
          Window window = {};
          Draw(part, look.appearance, &window);
          for (size_t pixel = 0; pixel < kPixelCount; ++pixel) {
            look.covered[pixel] = window[pixel].alpha >= kCoveredAlpha;
          }
        }
      }
    }
    return looks;
  }

 private:
  // A centered rectangle whose corner is on a pixel corner.
  static ScreenRect Middle(double width, double height) {
    return {std::round((kWindowSizePx - width) / 2), std::round((kWindowSizePx - height) / 2),
            width, height};
  }

  const Roles& roles_;
  const GameArt& art_;
  Scene scene_;
  float pixels_per_cell_ = 0;
};

// The number of pixels of the smaller look. The backdrop covers none and counts as large as the
// part.
size_t SmallerSize(const Look& first, const Look& second) {
  const size_t first_size = first.covered.count();
  const size_t second_size = second.covered.count();
  return std::min(first_size == 0 ? second_size : first_size,
                  second_size == 0 ? first_size : second_size);
}

float TotalDifference(const std::array<LabColor, kPixelCount>& first,
                      const std::array<LabColor, kPixelCount>& second,
                      const std::bitset<kPixelCount>& pixels) {
  float sum = 0;
  for (size_t i = 0; i < kPixelCount; ++i) {
    sum += pixels[i] ? ColorDifference(first[i], second[i]) : 0;
  }
  return sum;
}

// `distances`: one per window.
float Decide(std::vector<float> distances) {
  const auto worst = distances.begin() +
                     static_cast<ptrdiff_t>(kWorstShare * static_cast<double>(distances.size()));
  std::nth_element(distances.begin(), worst, distances.end());
  return *worst;
}

bool IsSeenOn(const Part& part, int backdrop_kind) {
  return std::find(part.backdrops.begin(), part.backdrops.end(), backdrop_kind) !=
         part.backdrops.end();
}

// Compares the looks of a game's parts, backdrop by backdrop.
class Comparison {
 public:
  Comparison(const Roles& roles, const PartRenderer& renderer, std::vector<Look> looks)
      : roles_(roles), renderer_(renderer), looks_(std::move(looks)) {}

  void CompareOn(const Backdrop& backdrop) {
    Look bare;
    bare.part = roles_.parts.size();
    DrawOn(backdrop, &bare);
    for (Look& look : looks_) {
      if (IsSeenOn(roles_.parts[look.part], backdrop.image_kind)) {
        DrawOn(backdrop, &look);
      } else {
        look.drawn.clear();
      }
    }
    for (size_t i = 0; i < looks_.size(); ++i) {
      Compare(looks_[i], bare, backdrop);
      for (size_t j = i + 1; j < looks_.size(); ++j) {
        if (MustDiffer(roles_.parts[looks_[i].part], roles_.parts[looks_[j].part])) {
          Compare(looks_[i], looks_[j], backdrop);
        }
      }
    }
  }

  std::vector<PartDistance> Result() && {
    std::vector<PartDistance> result;
    for (const auto& [parts, likeness] : likenesses_) {
      result.push_back(likeness);
    }
    std::stable_sort(
        result.begin(), result.end(),
        [](const PartDistance& a, const PartDistance& b) { return a.distance < b.distance; });
    return result;
  }

 private:
  const Part* PartOf(const Look& look) const {
    return look.part < roles_.parts.size() ? &roles_.parts[look.part] : nullptr;
  }

  void DrawOn(const Backdrop& backdrop, Look* look) const {
    look->drawn.resize(backdrop.windows.size());
    for (size_t i = 0; i < backdrop.windows.size(); ++i) {
      Window window = backdrop.windows[i];
      if (const Part* part = PartOf(*look); part != nullptr) {
        renderer_.Draw(*part, look->appearance, &window);
      }
      std::transform(window.begin(), window.end(), look->drawn[i].begin(), ToLab);
    }
  }

  void Compare(const Look& first, const Look& second, const Backdrop& backdrop) {
    if (first.drawn.empty() || second.drawn.empty()) {
      return;  // one of them is never seen on this backdrop
    }
    const std::bitset<kPixelCount> pixels = first.covered | second.covered;
    const auto size = static_cast<float>(std::max<size_t>(1, SmallerSize(first, second)));
    std::vector<float> distances(backdrop.windows.size());
    for (size_t i = 0; i < distances.size(); ++i) {
      distances[i] = TotalDifference(first.drawn[i], second.drawn[i], pixels) / size;
    }
    const float distance = Decide(std::move(distances));
    PartDistance& likeness = likenesses_[{first.part, second.part}];
    if (likeness.first == nullptr || distance < likeness.distance) {
      likeness = {.first = PartOf(first),
                  .second = PartOf(second),
                  .distance = distance,
                  .first_appearance = first.appearance,
                  .second_appearance = second.appearance,
                  .backdrop = backdrop.name};
    }
  }

  const Roles& roles_;
  const PartRenderer& renderer_;
  std::vector<Look> looks_;
  std::map<std::pair<size_t, size_t>, PartDistance> likenesses_;  // by first and second part
};

}  // namespace

std::vector<PartDistance> CompareParts(const Roles& roles, const SharedArt& art) {
  const std::unique_ptr<Game> stage = StageOf(roles);
  const auto game_art = art.Of(*FindGame(roles.game), stage->art());
  const PartRenderer renderer(roles, *stage, *game_art);
  Comparison comparison(roles, renderer, renderer.Looks(*stage));
  for (const Backdrop& backdrop : BackdropsOf(roles, *stage, *game_art)) {
    comparison.CompareOn(backdrop);
  }
  return std::move(comparison).Result();
}

}  // namespace procgen
