#include "envcore/render/scene/scene_drawing.h"

#include <algorithm>
#include <cmath>

#include "envcore/render/art/antialiased_sampling.h"
#include "envcore/render/art/nearest_sampling.h"
#include "envcore/render/raster/flat_rectangle.h"
#include "envcore/render/scene/overlay_drawing.h"
#include "envcore/render/scene/tiles.h"

namespace procgen {
namespace {

constexpr Rgba kBlack = {0, 0, 0, 255};
constexpr double kVelocitySquareShare = 0.2;  // of the frame's size
constexpr int kStripCellsInView = 16;         // of a scrolling background
constexpr double kStripWidth = 54;            // in frame sizes
constexpr double kStripHeight = 3;

enum class Sampling { kNearest, kAntialiased };

// Draws one scene on one frame.
template <Sampling kSampling>
class Drawing {
 public:
  // `cells`, `rows`: for nearest sampling; null for antialiased sampling.
  Drawing(const Scene& scene, const GameArt& art, const Frame& frame, CellDrawing* cells,
          CopyOnWriteRows* rows)
      : scene_(scene),
        art_(art),
        frame_(frame),
        viewport_(scene.camera, frame.size_px),
        cells_(scene.cells.grid == nullptr ? nullptr : cells),
        rows_(rows) {}

  // Draws the background, the sprites below the cells and the cells.
  void DrawStatic(const MipmappedImage* background) const {
    BeginCells();
    if (kSampling == Sampling::kNearest && frame_.size_px <= PixelSet::kSizePxMax) {
      DrawNeededBackground(background);
    } else {
      FillPixels(Whole(), kBlack, frame_);
      DrawBackground(background, nullptr);
    }
    for (const Sprite& sprite : scene_.below_cells) {
      DrawSprite(sprite);
    }
    DrawCells();
  }

  // Draws everything else.
  void DrawMoving() const {
    for (const Sprite& sprite : scene_.above_cells) {
      DrawSprite(sprite);
    }
    if (scene_.velocity.shown) {
      DrawVelocity();
    }
    for (const Overlay& overlay : scene_.overlays) {
      if constexpr (kSampling == Sampling::kNearest) {
        const RowRange touched = RowsOf(overlay, viewport_);
        rows_->Materialize(touched.top, touched.bottom, frame_);
        DrawOverlayAliased(overlay, viewport_, frame_);
      } else {
        DrawOverlayAntialiased(overlay, viewport_, frame_);
      }
    }
  }

 private:
  void BeginCells() const {
    if (cells_ != nullptr) {
      cells_->Begin(scene_, art_, viewport_, frame_);
    }
  }

  void DrawFlat(const ScreenRect& rect, const Rgba& color) const {
    if constexpr (kSampling == Sampling::kNearest) {
      DrawFlatAliased(rect, color, frame_);
    } else {
      DrawFlatAntialiased(rect, color, frame_);
    }
  }

  void DrawPicture(const SpriteArt& art, const ScreenRect& rect, float rotation,
                   float opacity) const {
    if constexpr (kSampling == Sampling::kAntialiased) {
      DrawAntialiased(*art.picture, rect, rotation, opacity, frame_);
    } else if (art.generated) {
      DrawNearestGenerated(*art.picture, rect, rotation, opacity, frame_);
    } else {
      DrawNearest(*art.picture, rect, rotation, opacity, frame_);
    }
  }

  // How far a drawing may extend beyond its rectangle, in pixels.
  static double MarginOf(const ScreenRect& rect, float rotation) {
    return rotation == 0 ? 1 : 1 + (std::abs(rect.width) + std::abs(rect.height)) / 2;
  }

  // Whether any part may be visible.
  bool IsInSight(const ScreenRect& rect, float rotation) const {
    const double margin = MarginOf(rect, rotation);
    const auto meets = [&](double from, double to) {
      return std::min(from, to) < frame_.size_px + margin && std::max(from, to) > -margin;
    };
    return meets(rect.x, rect.x + rect.width) && meets(rect.y, rect.y + rect.height);
  }

  // Prepares the rows of a visible rectangle for drawing.
  void MaterializeRows(const ScreenRect& rect, float rotation) const {
    if constexpr (kSampling == Sampling::kNearest) {
      const double margin = MarginOf(rect, rotation);
      const double top = std::min(rect.y, rect.y + rect.height) - margin;
      const double bottom = std::max(rect.y, rect.y + rect.height) + margin + 1;
      rows_->Materialize(static_cast<int>(std::max(top, 0.0)),
                         static_cast<int>(std::min<double>(bottom, frame_.size_px)), frame_);
    }
  }

  template <typename Draw>
  void ForEachTileInSight(const ScreenRect& rect, float ratio, Draw draw) const {
    ForEachTile(rect, ratio, [&](const ScreenRect& tile) {
      if (IsInSight(tile, 0)) {
        draw(tile);
      }
    });
  }

  PixelBox Whole() const { return {0, 0, frame_.size_px, frame_.size_px}; }

  void DrawBackdrop(const MipmappedImage& picture, const ScreenRect& rect,
                    BackdropPixels* pixels) const {
    if constexpr (kSampling == Sampling::kNearest) {
      DrawNearestBackdrop(
          picture, rect,
          scene_.background.scrolls ? BackdropMotion::kSideways : BackdropMotion::kAny, pixels,
          frame_);
    } else {
      DrawAntialiased(picture, rect, 0, 1, frame_);
    }
  }

  // Draws the background where the cells do not hide it; black where there is no background.
  void DrawNeededBackground(const MipmappedImage* picture) const {
    BackdropPixels pixels;
    if (cells_ != nullptr) {
      cells_->AddHidden(&pixels.hidden);
      pixels.done = pixels.hidden;
    }
    DrawBackground(picture, &pixels);
    for (int row = 0; row < frame_.size_px; ++row) {
      pixels.done.ForEachRunOutside(row, 0, frame_.size_px, [&](int first, int end) {
        FillRun(frame_.At(first, row), static_cast<size_t>(end - first), kBlack);
      });
    }
  }

  // `background`: null: draws nothing.
  void DrawBackground(const MipmappedImage* background, BackdropPixels* pixels) const {
    if (background == nullptr) {
      return;
    }
    const MipmappedImage& picture = *background;
    if (scene_.background.scrolls) {
      DrawStrip(picture, pixels);
      return;
    }
    const auto world_w = static_cast<float>(scene_.world_width);
    const auto world_h = static_cast<float>(scene_.world_height);
    const ScreenRect world = viewport_.InWorld(0, world_h, world_w, world_h, 0);
    const float tile_ratio = scene_.background.tile_ratio;
    if (tile_ratio != 0) {
      ForEachTileInSight(world, tile_ratio,
                         [&](const ScreenRect& tile) { DrawBackdrop(picture, tile, pixels); });
      return;
    }
    const Image& image = picture.level(0);
    const float picture_ratio =
        static_cast<float>(image.width()) / static_cast<float>(image.height());
    const auto world_ratio =
        static_cast<float>(static_cast<double>(world_w) / static_cast<double>(world_h));
    const float shift = scene_.background.offset * (picture_ratio - world_ratio);
    const float stretch = picture_ratio / world_ratio;
    DrawBackdrop(picture,
                 {world.x + world.width * static_cast<double>(-shift), world.y,
                  world.width * static_cast<double>(stretch), world.height},
                 pixels);
  }

  // Draws a strip of a scrolling background. The view shows the middle third of its height.
  void DrawStrip(const MipmappedImage& picture, BackdropPixels* pixels) const {
    const int pixels_per_cell = frame_.size_px / kStripCellsInView;  // truncated
    const auto steps = static_cast<float>(scene_.background.scrolled_steps);
    const float left = (((-steps * static_cast<float>(pixels_per_cell)) * 0.5F) * 2) / 5;
    const double side = frame_.size_px;
    ForEachTileInSight({static_cast<double>(left), -side, kStripWidth * side, kStripHeight * side},
                       1, [&](const ScreenRect& tile) { DrawBackdrop(picture, tile, pixels); });
  }

  SpriteArt ArtOf(int kind, int theme, bool mirrored) const {
    return scene_.art_style == ArtStyle::kGenerated ? art_.GeneratedOf(kind, mirrored)
                                                    : art_.SpriteOf(kind, theme, mirrored);
  }

  void DrawSprite(const Sprite& sprite) const {
    const ScreenRect box = sprite.screen_coordinates
                               ? viewport_.OfShares(sprite.x, sprite.y, sprite.rx, sprite.ry)
                               : viewport_.OfBox(sprite.x, sprite.y, sprite.rx, sprite.ry);
    const bool is_flat = scene_.art_style == ArtStyle::kMonochrome;
    const ScreenRect rect = is_flat ? box
                                    : ScreenRect{box.x, box.y + box.height * sprite.art_top,
                                                 box.width, box.height * sprite.art_height};
    if (!IsInSight(rect, sprite.rotation)) {
      return;
    }
    MaterializeRows(rect, sprite.rotation);
    if (is_flat) {
      DrawFlat(rect, MonochromeColor(sprite.image_kind, sprite.theme));
      return;
    }
    const SpriteArt art = ArtOf(sprite.image_kind, sprite.theme, sprite.mirrored);
    if (sprite.tile_ratio != 0 && sprite.rotation == 0) {
      ForEachTileInSight(rect, sprite.tile_ratio, [&](const ScreenRect& tile) {
        DrawPicture(art, tile, 0, sprite.opacity);
      });
      return;
    }
    DrawPicture(art, rect, sprite.rotation, sprite.opacity);
  }

  void DrawCells() const {
    const CellLayer& cells = scene_.cells;
    if (cells.grid == nullptr) {
      return;
    }
    if constexpr (kSampling == Sampling::kNearest) {
      cells_->Draw();
      return;
    }
    for (int x = cells.first_column; x <= cells.last_column; ++x) {
      for (int y = cells.first_row; y <= cells.last_row; ++y) {
        const int kind =
            cells.grid->Contains(x, y) ? cells.grid->At(x, y) : cells.out_of_bounds_kind;
        if (kind == cells.dots.kind && kind != kOutsideKind) {
          DrawDot(x, y, cells.dots);
        } else if (kind >= 0 && kind < kKindCount) {
          DrawCell(x, y, cells.looks[static_cast<size_t>(kind)]);
        }
      }
    }
  }

  void DrawCell(int x, int y, const CellAppearance& look) const {
    if (look.image_kind < 0) {
      return;
    }
    const ScreenRect rect = viewport_.OfCell(x, y);
    if (scene_.art_style == ArtStyle::kMonochrome) {
      DrawFlat(rect, MonochromeColor(look.image_kind, look.theme));
    } else {
      DrawPicture(ArtOf(look.image_kind, look.theme, false), rect, 0, 1);
    }
  }

  void DrawDot(int x, int y, const CellDots& dots) const {
    const ScreenRect cell = viewport_.OfCell(x, y);
    const auto share = static_cast<double>(dots.share);
    const auto rest = static_cast<double>(1 - dots.share);
    DrawFlat({cell.x + cell.width * rest / 2, cell.y + cell.height * rest / 2, cell.width * share,
              cell.height * share},
             {dots.color[0], dots.color[1], dots.color[2], 255});
  }

  void DrawVelocity() const {
    const VelocityDisplay& velocity = scene_.velocity;
    const auto side =
        static_cast<double>(static_cast<float>(frame_.size_px * kVelocitySquareShare));
    MaterializeRows({0, 0, side, side}, 0);
    DrawFlat({0, 0, side, side}, VelocityGrey(velocity.vx, velocity.vx_max));
    DrawFlat({side, 0, side, side}, VelocityGrey(velocity.vy, velocity.vy_max));
  }

  static Rgba VelocityGrey(float speed, float top_speed) {
    const auto share =
        static_cast<float>(0.5 * static_cast<double>(speed) / static_cast<double>(top_speed) + 0.5);
    const float level = share * 255;
    const auto grey = static_cast<uint8_t>(std::clamp(level, 0.0F, 255.0F));
    return {grey, grey, grey, 255};
  }

  const Scene& scene_;
  const GameArt& art_;
  const Frame& frame_;
  const Viewport viewport_;
  CellDrawing* const cells_;
  CopyOnWriteRows* const rows_;
};

}  // namespace

void DrawNearestScene(const Scene& scene, const GameArt& art, const MipmappedImage* background,
                      CellDrawing* cells, StaticLayerCache* static_layer, CopyOnWriteRows* rows,
                      const Frame& frame) {
  const Drawing<Sampling::kNearest> drawing(scene, art, frame, cells, rows);
  const StaticLayerCache::Use use =
      static_layer == nullptr ? StaticLayerCache::Use::kDrawOnly : static_layer->Classify(scene);
  rows->Clear();
  if (use != StaticLayerCache::Use::kCopy) {
    drawing.DrawStatic(background);
  } else if (frame.size_px <= CopyOnWriteRows::kSizePxMax) {
    rows->ShareAll(*static_layer, frame.size_px);
  } else {
    static_layer->CopyRows(0, frame.size_px, frame);
  }
  if (use == StaticLayerCache::Use::kKeep) {
    static_layer->Keep(frame);
  }
  drawing.DrawMoving();
}

void DrawAntialiasedScene(const Scene& scene, const GameArt& art, const MipmappedImage* background,
                          const Frame& frame) {
  const Drawing<Sampling::kAntialiased> drawing(scene, art, frame, nullptr, nullptr);
  drawing.DrawStatic(background);
  drawing.DrawMoving();
}

}  // namespace procgen
