#include "tools/art/backdrops.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "envcore/environment/environment_options.h"
#include "envcore/render/art/nearest_sampling.h"
#include "envcore/render/scene/rasteriser.h"

namespace procgen {
namespace {

// A camera position as fractions of the world, and the shift or scroll of a background. Low
// positions are more frequent, because they are seen more often.
struct Place {
  float x = 0;
  float y = 0;
  float offset = 0;
  int32_t scrolled_steps = 0;
};
constexpr Place kPlaces[] = {
    {0.2F, 0.15F, 0.1F, 0}, {0.5F, 0.35F, 0.5F, 300}, {0.8F, 0.7F, 0.9F, 700}};

// The first pixels of the windows of a view, on both axes.
constexpr int kWindowStarts[] = {4, 36};

void CutWindows(absl::Span<const uint8_t> view, std::vector<Window>* windows) {
  for (const int top : kWindowStarts) {
    for (const int left : kWindowStarts) {
      Rgba* pixel = windows->emplace_back().data();
      for (int y = 0; y < kWindowSizePx; ++y) {
        for (int x = 0; x < kWindowSizePx; ++x) {
          const int from = ((top + y) * kUpstreamFrameFormat.size_px + left + x) * 3;
          const uint8_t* rgb = view.data() + from;
          *pixel++ = {rgb[0], rgb[1], rgb[2], 255};
        }
      }
    }
  }
}

// The center of a view at a fraction of the world's length, moved so that the view stays inside the
// world; the middle if the view is larger than the world.
float CenterInside(float share, int world_cells, float view_cells) {
  const auto length = static_cast<float>(world_cells);
  if (length <= view_cells) {
    return length / 2;
  }
  return std::clamp(share * length, view_cells / 2, length - view_cells / 2);
}

Backdrop BackgroundBackdrop(const Game& stage, const GameArt& art, int index,
                            Rasteriser* rasteriser) {
  Backdrop backdrop;
  backdrop.name = absl::StrCat("background ", index);
  Scene scene;
  stage.FillScene(&scene);
  scene.Clear();
  scene.cells.grid = nullptr;
  scene.background.index = index;
  std::array<uint8_t, kUpstreamFrameFormat.bytes()> view = {};
  for (const Place& place : kPlaces) {
    scene.camera.center_x = CenterInside(place.x, scene.world_width, scene.camera.cells);
    scene.camera.center_y = CenterInside(place.y, scene.world_height, scene.camera.cells);
    scene.background.offset = place.offset;
    scene.background.scrolled_steps = scene.background.scrolls ? place.scrolled_steps : 0;
    rasteriser->DrawAgentView(scene, art, nullptr, kUpstreamFrameFormat, absl::MakeSpan(view));
    CutWindows(view, &backdrop.windows);
  }
  return backdrop;
}

// A backdrop of adjacent cells.
Backdrop PictureBackdrop(const GameArt& art, int image_kind, int theme, float pixels_per_cell) {
  Backdrop backdrop;
  backdrop.image_kind = image_kind;
  backdrop.name = absl::StrCat("image kind ", image_kind, " theme ", theme);
  const MipmappedImage& picture = *art.SpriteOf(image_kind, theme, false).picture;
  Window& window = backdrop.windows.emplace_back();
  window.fill({0, 0, 0, 255});
  const Frame frame = {window.data(), kWindowSizePx};
  const double side = pixels_per_cell;
  const int cells = static_cast<int>(std::ceil(kWindowSizePx / side));
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      DrawNearest(picture, {column * side, row * side, side, side}, 0, 1, frame);
    }
  }
  return backdrop;
}

}  // namespace

std::unique_ptr<Game> StageOf(const Roles& roles) {
  EnvironmentOptions options;
  options.distribution_mode = roles.mode;
  std::unique_ptr<Game> game =
      FindGame(roles.game)->make(ResolveOptions(roles.game, options).value());
  game->StartLevel(0);
  return game;
}

std::vector<Backdrop> BackdropsOf(const Roles& roles, const Game& stage, const GameArt& art) {
  std::set<int> image_kinds;
  for (const Part& part : roles.parts) {
    image_kinds.insert(part.backdrops.begin(), part.backdrops.end());
  }
  Scene scene;
  stage.FillScene(&scene);
  const float pixels_per_cell = kUpstreamFrameFormat.size_px / scene.camera.cells;
  Rasteriser rasteriser;
  std::vector<Backdrop> backdrops;
  for (const int kind : image_kinds) {
    const bool is_background = kind == kBackgroundBackdrop;
    const int count = is_background ? static_cast<int>(BackgroundsOf(scene.background.group).size())
                                    : ThemeCountOf(stage, kind);
    for (int i = 0; i < count; ++i) {
      backdrops.push_back(is_background ? BackgroundBackdrop(stage, art, i, &rasteriser)
                                        : PictureBackdrop(art, kind, i, pixels_per_cell));
    }
  }
  return backdrops;
}

int ThemeCountOf(const Game& stage, int image_kind) {
  const auto slots = stage.art().slots;
  return std::max(
      1, static_cast<int>(std::count_if(slots.begin(), slots.end(), [&](const ArtSlot& slot) {
        return slot.kind == image_kind;
      })));
}

}  // namespace procgen
