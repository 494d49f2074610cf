#ifndef ENVCORE_RENDER_SCENE_CELL_DRAWING_H_
#define ENVCORE_RENDER_SCENE_CELL_DRAWING_H_

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/types/span.h"
#include "envcore/render/art/game_art.h"
#include "envcore/render/art/scaled_image_cache.h"
#include "envcore/render/art/upright_image.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/raster/pixel_set.h"
#include "envcore/scene/camera.h"
#include "envcore/scene/scene.h"

namespace procgen {

// Draws the cells of scenes in the agent's view. The positions of columns and rows, and the look of
// each kind, are computed once per frame. Keeps its buffers from frame to frame.
// Threads: compatible (one thread at a time).
class CellDrawing {
 public:
  CellDrawing() { dot_.way = Look::Way::kDot; }

  // Prepares for the cells of `scene`. All arguments must stay valid until the frame is drawn.
  // REQUIRES: scene.cells.grid is not null.
  void Begin(const Scene& scene, const GameArt& art, const Viewport& viewport, const Frame& frame);

  // Adds the pixels that the cells will completely cover. REQUIRES: the frame's size is at most
  // PixelSet::kSizePxMax.
  void AddHidden(PixelSet* hidden);

  void Draw();

 private:
  // Pixels [first, end) of a column or row of cells, or of their dots. Not clipped.
  struct PixelRange {
    // The pixels whose centers are in [from, from + length). REQUIRES: length >= 0.
    static PixelRange Of(double from, double length) {
      return {RoundPx(from), RoundPx(from + length)};
    }

    int first = 0;
    int end = 0;
  };

  // Where the cells of one axis show an image, whose size on that axis is source_size.
  struct AxisPositions {
    // Of the cells [first, end). REQUIRES: there is one cell, or the cells adjoin.
    SourcePositions At(int first, int end) const {
      const Range& from = ranges[static_cast<size_t>(first)];
      const Range& last = ranges[static_cast<size_t>(end - 1)];
      return {from.first, absl::MakeConstSpan(sources).subspan(
                              from.begin, last.begin + last.count - from.begin)};
    }

    struct Range {
      int first;     // pixel
      size_t begin;  // in sources
      size_t count;
    };
    int source_size = 0;
    bool adjoin = false;        // no pixel between two cells is left out
    std::vector<Range> ranges;  // by cell
    std::vector<int32_t> sources;
  };
  // Those of a frame. Keeps the memory of earlier frames.
  struct AxisPositionsList {
    std::vector<std::unique_ptr<AxisPositions>> all;
    size_t count = 0;  // of this frame
  };

  // How the cells of a kind are drawn.
  struct Look {
    enum class Way : uint8_t { kNothing, kFlat, kScaled, kStretched, kPicture, kDot };
    int64_t frame_number = 0;  // frame that it was computed for
    Way way = Way::kNothing;
    bool opaque = false;
    Rgba color;
    SpriteArt art;
    // Of kStretched.
    const AxisPositions* across = nullptr;
    const AxisPositions* down = nullptr;
    // By height and width above their minima; null: not looked up yet.
    std::array<std::array<std::shared_ptr<const ScaledImage>, 2>, 2> scaled;
  };

  // Adjoining cells of one look in one row or one column, by index in columns_ and rows_.
  struct CellRun {
    Look* look;
    int column;
    int end_column;
    int row;
    int end_row;
  };

  // Whether any cell in view is not empty.
  bool HasCells() const;
  void FindRanges(const Viewport& viewport);
  // Whether cells may overlap diagonally, by rounding: only then does the order of rows matter.
  bool MayOverlapDiagonally() const;
  // Lists the cells to draw.
  void FindCells();
  // Calls add(look, from, to) for the runs of a row or column of `count` cells in view, of which
  // [first, end) are in the grid and have the kinds kind_at(cell).
  template <typename KindAt, typename Add>
  void FindRunsOfLine(int first, int end, int count, KindAt kind_at, Add add);
  // Lists them row by row, in runs: cheapest to draw.
  void FindRowRuns();
  // Lists them column by column, in runs: upstream's order.
  void FindColumnRuns();
  Look FindLook(int kind);
  // Returns where cells [first, last] of an axis show an image of `source_size`. `start_and_size`:
  // of a cell's rectangle on that axis.
  template <typename StartAndSize>
  const AxisPositions* PositionsOf(int first, int last, int source_size,
                                   StartAndSize start_and_size, AxisPositionsList* list) const;
  // How the cells of a kind are drawn; null: they are not drawn.
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
  // The columns of pixels that a run covers, as bits.
  uint64_t ColumnsOf(const CellRun& run) const;
  // Calls draw(column, row) for the cells of a run.
  template <typename DrawCell>
  static void ForEachCell(const CellRun& run, DrawCell draw);
  void DrawFlatRun(const CellRun& run) const;
  void DrawStretchedRun(const CellRun& run) const;
  void DrawDot(PixelRange across, PixelRange down) const;
  void DrawPicture(const Look& look, int column, int row) const;
  void DrawScaledCell(Look& look, PixelRange across, PixelRange down) const;

  const CellLayer* cells_ = nullptr;
  const GameArt* art_ = nullptr;
  ArtStyle style_ = ArtStyle::kPictures;
  const Viewport* viewport_ = nullptr;
  const Frame* frame_ = nullptr;
  std::vector<PixelRange> columns_;  // of the view, starting at cells_->first_column
  std::vector<PixelRange> rows_;
  std::vector<PixelRange> dot_columns_;  // of the dots; empty: no dots
  std::vector<PixelRange> dot_rows_;
  bool columns_adjoin_ = false;  // no pixel between two columns is left out or in both
  int width_min_ = 0;            // smallest range
  int height_min_ = 0;
  bool scales_ = false;  // the ranges are small enough for scaled images
  AxisPositionsList across_;
  AxisPositionsList down_;
  std::vector<CellRun> shown_;
  std::vector<uint64_t>
      hidden_of_rows_;  // by place in rows_: the pixels hidden in each of its lines
  int64_t frame_number_ = 0;
  std::array<Look, kKindCount> looks_;  // by kind
  Look dot_;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_CELL_DRAWING_H_
