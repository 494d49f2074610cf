#include "envcore/render/scene/static_layer_cache.h"

#include <algorithm>
#include <cstddef>

#include "absl/types/span.h"
#include "envcore/render/output/frame_packing.h"

namespace procgen {
namespace {

// Number of repetitions before the static part is cached: a camera that stops for a moment will
// move again.
constexpr int kRepeatsMin = 2;

// Calls `use` with the kinds of each row of the grid that is in view, clipped to the grid. Stops
// and returns false when `use` returns false.
template <typename Use>
bool ForEachRow(const CellLayer& cells, Use use) {
  const Grid& grid = *cells.grid;
  const int first_column = std::max(cells.first_column, 0);
  const int last_column = std::min(cells.last_column, grid.width() - 1);
  const int last_row = std::min(cells.last_row, grid.height() - 1);
  if (first_column > last_column) {
    return true;
  }
  const int column_count = last_column - first_column + 1;
  const auto count = static_cast<size_t>(column_count);
  for (int row = std::max(cells.first_row, 0); row <= last_row; ++row) {
    if (!use(grid.Row(row).subspan(static_cast<size_t>(first_column), count))) {
      return false;
    }
  }
  return true;
}

// Whether the layers are equal except for the kinds of their cells.
bool SameWindow(const CellLayer& a, const CellLayer& b) {
  return a.first_column == b.first_column && a.last_column == b.last_column &&
         a.first_row == b.first_row && a.last_row == b.last_row &&
         a.out_of_bounds_kind == b.out_of_bounds_kind && a.dots == b.dots && a.looks == b.looks;
}

}  // namespace

StaticLayerCache::Use StaticLayerCache::Classify(const Scene& scene) {
  if (!Knows(scene)) {
    Remember(scene);
    repeat_count_ = 0;
    rgb_.clear();
    return Use::kDrawOnly;
  }
  if (!rgb_.empty()) {
    return Use::kCopy;
  }
  return ++repeat_count_ < kRepeatsMin ? Use::kDrawOnly : Use::kKeep;
}

void StaticLayerCache::Keep(const Frame& frame) {
  size_px_ = frame.size_px;
  const absl::Span<const Rgba> pixels = frame.Rows(0, size_px_);
  rgb_.resize(3 * pixels.size());
  PackFrame(pixels, Color::kRgb, Layout::kHwc, absl::MakeSpan(rgb_));
}

void StaticLayerCache::CopyRows(int first, int end, const Frame& frame) const {
  UnpackRgb(Rows(first, end), frame.Rows(first, end));
}

absl::Span<const uint8_t> StaticLayerCache::Rows(int first, int end) const {
  const size_t row_bytes = 3 * static_cast<size_t>(size_px_);
  return absl::MakeConstSpan(rgb_).subspan(static_cast<size_t>(first) * row_bytes,
                                           static_cast<size_t>(end - first) * row_bytes);
}

bool StaticLayerCache::Knows(const Scene& scene) const {
  // The address of a generated background does not identify its content.
  if (!met_ || scene.background.generated != nullptr || !(scene.camera == camera_) ||
      !(scene.background == background_) || scene.world_width != world_width_ ||
      scene.world_height != world_height_ || scene.art_style != art_style_ ||
      scene.below_cells != below_cells_ || (scene.cells.grid != nullptr) != has_cells_) {
    return false;
  }
  if (!has_cells_) {
    return true;
  }
  if (scene.cells.grid->width() != grid_width_ || scene.cells.grid->height() != grid_height_ ||
      !SameWindow(scene.cells, cells_)) {
    return false;
  }
  const int16_t* known = kinds_.data();
  return ForEachRow(scene.cells, [&known](absl::Span<const int16_t> kinds) {
    const bool same = std::equal(kinds.begin(), kinds.end(), known);
    known += kinds.size();
    return same;
  });
}

void StaticLayerCache::Remember(const Scene& scene) {
  met_ = true;
  camera_ = scene.camera;
  background_ = scene.background;
  world_width_ = scene.world_width;
  world_height_ = scene.world_height;
  art_style_ = scene.art_style;
  below_cells_ = scene.below_cells;
  const Grid* const grid = scene.cells.grid;
  has_cells_ = grid != nullptr;
  kinds_.clear();
  if (grid == nullptr) {
    return;
  }
  grid_width_ = grid->width();
  grid_height_ = grid->height();
  ForEachRow(scene.cells, [this](absl::Span<const int16_t> kinds) {
    kinds_.insert(kinds_.end(), kinds.begin(), kinds.end());
    return true;
  });
  cells_ = scene.cells;
  cells_.grid = nullptr;
}

}  // namespace procgen
