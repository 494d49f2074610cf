#ifndef ENVCORE_RENDER_SCENE_CELL_DRAWING_H_
#define ENVCORE_RENDER_SCENE_CELL_DRAWING_H_

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "envcore/render/art/game_art.h"
#include "envcore/render/art/scaled_image_cache.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/raster/pixel_set.h"
#include "envcore/scene/camera.h"
#include "envcore/scene/scene.h"

namespace procgen {

// Draws the cells of scenes as the agent sees them. Where a column or a row of cells stands, and
// how a kind looks, is found once for each frame. Keeps its memory from frame to frame.
// Threads: compatible (one thread at a time).
class CellDrawing {
 public:
  CellDrawing() { dot_.way = Look::Way::kDot; }

  // Gets ready for the cells of `scene`. All must stay valid until the frame is drawn.
  // REQUIRES: scene.cells.grid is not null.
  void Begin(const Scene& scene, const GameArt& art, const Viewport& viewport, const Frame& frame);

  // Which pixels the cells will cover wholly. REQUIRES: the frame's side is PixelSet::kSizePxMax at
  // most.
  void AddHidden(PixelSet* hidden);

  void Draw();

 private:
  // Pixels of a column or row of cells, or of what is in its middle: [first, end), not clipped.
  struct PixelRange {
    // Those whose centre lies in [from, from + length). REQUIRES: length >= 0.
    static PixelRange Of(double from, double length) {
      return {RoundPx(from), RoundPx(from + length)};
    }

    int first = 0;
    int end = 0;
  };

  // How the cells of a kind are drawn.
  struct Look {
    enum class Way : uint8_t { kNothing, kFlat, kScaled, kPicture, kDot };
    int64_t frame_number = 0;  // that it was found for
    Way way = Way::kNothing;
    bool opaque = false;
    Rgba color;
    SpriteArt art;
    // By height above the least, width above the least; null: not looked at yet.
    std::array<std::array<std::shared_ptr<const ScaledImage>, 2>, 2> scaled;
  };

  // A cell in view, by its place in columns_ and rows_.
  struct Cell {
    Look* look;
    int column;
    int row;
  };

  // Whether any cell in view is not empty.
  bool HasCells() const;
  void FindRanges(const Viewport& viewport);
  // Lists the cells that are to be drawn, in the order of drawing: column by column.
  void FindCells();
  Look FindLook(int kind) const;
  // How the cells of a kind are drawn; null: not at all.
  Look* LookOf(int kind) {
    if (kind == cells_->dots.kind && kind != kOutsideKind) {
      return &dot_;
    }
    if (kind < 0 || kind >= kKindCount) {
      return nullptr;
    }
    Look& look = looks_[static_cast<size_t>(kind)];
    if (look.frame_number != frame_number_) {
      look = FindLook(kind);
    }
    return look.way == Look::Way::kNothing ? nullptr : &look;
  }
  void DrawDot(PixelRange across, PixelRange down) const;
  void DrawPicture(const Look& look, int column, int row) const;
  void DrawScaledCell(Look& look, PixelRange across, PixelRange down) const;

  const CellLayer* cells_ = nullptr;
  const GameArt* art_ = nullptr;
  ArtStyle style_ = ArtStyle::kPictures;
  const Viewport* viewport_ = nullptr;
  const Frame* frame_ = nullptr;
  std::vector<PixelRange> columns_;  // of the view, from cells_->first_column on
  std::vector<PixelRange> rows_;
  std::vector<PixelRange> dot_columns_;  // of the dots in them; empty: there are none
  std::vector<PixelRange> dot_rows_;
  int width_min_ = 0;  // of the ranges
  int height_min_ = 0;
  bool scales_ = false;  // the ranges are small enough for scaled pictures
  std::vector<Cell> shown_;
  std::vector<uint64_t>
      hidden_of_rows_;  // by place in rows_: the pixels hidden in each of its lines
  int64_t frame_number_ = 0;
  std::array<Look, kKindCount> looks_;  // by kind
  Look dot_;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_CELL_DRAWING_H_
