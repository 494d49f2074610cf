#include "tools/art/legibility.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <memory>

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

void ToLab(const Window& window, std::array<LabColor, kPixelCount>* colors) {
  std::transform(window.begin(), window.end(), colors->begin(),
                 [](const Rgba& pixel) { return ToLab(pixel); });
}

// The pixels that at least one of two looks covers.
std::vector<size_t> CoveredByEither(const Look& first, const Look& second) {
  std::vector<size_t> pixels;
  for (size_t i = 0; i < kPixelCount; ++i) {
    if (first.covered[i] || second.covered[i]) {
      pixels.push_back(i);
    }
  }
  return pixels;
}

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
                      const std::vector<size_t>& pixels) {
  float sum = 0;
  for (const size_t i : pixels) {
    sum += ColorDifference(first[i], second[i]);
  }
  return sum;
}

// The window of a backdrop that determines the distance.
struct WorstWindow {
  size_t window = 0;
  float distance = 0;
};

// `distances`: one per window.
WorstWindow Decide(const std::vector<float>& distances) {
  std::vector<WorstWindow> windows;
  for (size_t i = 0; i < distances.size(); ++i) {
    windows.push_back({.window = i, .distance = distances[i]});
  }
  const auto worst =
      windows.begin() + static_cast<ptrdiff_t>(kWorstShare * static_cast<double>(windows.size()));
  std::nth_element(
      windows.begin(), worst, windows.end(),
      [](const WorstWindow& a, const WorstWindow& b) { return a.distance < b.distance; });
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
      : roles_(roles), renderer_(renderer), looks_(std::move(looks)) {
    // The backdrop counts as an additional part.
    const size_t count = roles.parts.size();
    likenesses_.resize(count * (count + 1));
  }

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
    std::copy_if(likenesses_.begin(), likenesses_.end(), std::back_inserter(result),
                 [](const PartDistance& likeness) { return likeness.first != nullptr; });
    std::stable_sort(
        result.begin(), result.end(),
        [](const PartDistance& a, const PartDistance& b) { return a.distance < b.distance; });
    return result;
  }

 private:
  const Part* PartOf(const Look& look) const {
    return look.part < roles_.parts.size() ? &roles_.parts[look.part] : nullptr;
  }

  Window WindowOf(const Look& look, const Window& backdrop) const {
    Window window = backdrop;
    if (const Part* part = PartOf(look); part != nullptr) {
      renderer_.Draw(*part, look.appearance, &window);
    }
    return window;
  }

  void DrawOn(const Backdrop& backdrop, Look* look) const {
    look->drawn.resize(backdrop.windows.size());
    for (size_t i = 0; i < backdrop.windows.size(); ++i) {
      ToLab(WindowOf(*look, backdrop.windows[i]), &look->drawn[i]);
    }
  }

  void Compare(const Look& first, const Look& second, const Backdrop& backdrop) {
    if (first.drawn.empty() || second.drawn.empty()) {
      return;  // one of them is never seen on this backdrop
    }
    const std::vector<size_t> pixels = CoveredByEither(first, second);
    const auto size = static_cast<float>(std::max<size_t>(1, SmallerSize(first, second)));
    std::vector<float> distances(backdrop.windows.size());
    for (size_t i = 0; i < distances.size(); ++i) {
      distances[i] = TotalDifference(first.drawn[i], second.drawn[i], pixels) / size;
    }
    const WorstWindow worst = Decide(distances);
    PartDistance& likeness = likenesses_[first.part * (roles_.parts.size() + 1) + second.part];
    if (likeness.first == nullptr || worst.distance < likeness.distance) {
      likeness = {.first = PartOf(first),
                  .second = PartOf(second),
                  .distance = worst.distance,
                  .first_appearance = first.appearance,
                  .second_appearance = second.appearance,
                  .backdrop = backdrop.name,
                  .first_window = WindowOf(first, backdrop.windows[worst.window]),
                  .second_window = WindowOf(second, backdrop.windows[worst.window])};
    }
  }

  const Roles& roles_;
  const PartRenderer& renderer_;
  std::vector<Look> looks_;
  std::vector<PartDistance> likenesses_;  // by first and second part; first == null: not compared
};

}  // namespace

std::vector<PartDistance> CompareParts(const Roles& roles, const SharedArt& art,
                                       absl::FunctionRef<void(int64_t, int64_t)> show) {
  const std::unique_ptr<Game> stage = StageOf(roles);
  const auto game_art = art.Of(*FindGame(roles.game), stage->art());
  const PartRenderer renderer(roles, *stage, *game_art);
  Comparison comparison(roles, renderer, renderer.Looks(*stage));
  const std::vector<Backdrop> backdrops = BackdropsOf(roles, *stage, *game_art);
  for (size_t i = 0; i < backdrops.size(); ++i) {
    comparison.CompareOn(backdrops[i]);
    show(static_cast<int64_t>(i) + 1, static_cast<int64_t>(backdrops.size()));
  }
  return std::move(comparison).Result();
}

}  // namespace procgen
