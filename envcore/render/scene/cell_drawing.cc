#include "envcore/render/scene/cell_drawing.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "envcore/render/art/nearest_sampling.h"
#include "envcore/render/art/scaled_drawing.h"
#include "envcore/render/raster/axis_steps.h"
#include "envcore/render/raster/flat_rectangle.h"

namespace procgen {
namespace {

constexpr uint32_t kOpaque = 255;

}  // namespace

void CellDrawing::Begin(const Scene& scene, const GameArt& art, const Viewport& viewport,
                        const Frame& frame) {
  cells_ = &scene.cells;
  art_ = &art;
  style_ = scene.art_style;
  viewport_ = &viewport;
  frame_ = &frame;
  ++frame_number_;
  shown_.clear();
  columns_.clear();
  rows_.clear();
  dot_columns_.clear();
  dot_rows_.clear();
  across_.count = 0;
  down_.count = 0;
  if (HasCells()) {
    FindRanges(viewport);
    FindCells();
  }
}

bool CellDrawing::HasCells() const {
  const Grid& grid = *cells_->grid;
  const int first_column = std::max(cells_->first_column, 0);
  const int last_column = std::min(cells_->last_column, grid.width() - 1);
  const bool all_in_grid = cells_->first_column >= 0 && cells_->last_column < grid.width() &&
                           cells_->first_row >= 0 && cells_->last_row < grid.height();
  if (!all_in_grid && cells_->out_of_bounds_kind != kOutsideKind) {
    return true;
  }
  const int last_row = std::min(cells_->last_row, grid.height() - 1);
  const int column_count = last_column - first_column + 1;
  for (int y = std::max(cells_->first_row, 0); y <= last_row && column_count > 0; ++y) {
    const absl::Span<const int16_t> kinds =
        grid.Row(y).subspan(static_cast<size_t>(first_column), static_cast<size_t>(column_count));
    if (std::any_of(kinds.begin(), kinds.end(), [](int kind) { return kind != kEmptyKind; })) {
      return true;
    }
  }
  return false;
}

void CellDrawing::FindRanges(const Viewport& viewport) {
  const CellDots& dots = cells_->dots;
  const bool has_dots = dots.kind != kOutsideKind;
  const auto share = static_cast<double>(dots.share);
  const auto rest = static_cast<double>(1 - dots.share);
  const auto add = [&](double from, double length, std::vector<PixelRange>* ranges,
                       std::vector<PixelRange>* dot_ranges) {
    ranges->push_back(PixelRange::Of(from, length));
    if (has_dots) {
      dot_ranges->push_back(PixelRange::Of(from + length * rest / 2, length * share));
    }
  };
  for (int x = cells_->first_column; x <= cells_->last_column; ++x) {
    const ScreenRect rect = viewport.OfCell(x, 0);
    add(rect.x, rect.width, &columns_, &dot_columns_);
  }
  for (int y = cells_->first_row; y <= cells_->last_row; ++y) {
    const ScreenRect rect = viewport.OfCell(0, y);
    add(rect.y, rect.height, &rows_, &dot_rows_);
  }
  dot_.color = {dots.color[0], dots.color[1], dots.color[2], 255};
  const auto least = [](const std::vector<PixelRange>& ranges) {
    int size = ScaledImageCache::kSizePxMax;
    for (const PixelRange& range : ranges) {
      size = std::min(size, range.end - range.first);
    }
    return size;
  };
  columns_adjoin_ = std::adjacent_find(columns_.begin(), columns_.end(),
                                       [](const PixelRange& left, const PixelRange& right) {
                                         return left.end != right.first;
                                       }) == columns_.end();
  width_min_ = least(columns_);
  height_min_ = least(rows_);
  // The ranges of one axis differ by at most one pixel.
  scales_ = width_min_ > 0 && width_min_ < ScaledImageCache::kSizePxMax && height_min_ > 0 &&
            height_min_ < ScaledImageCache::kSizePxMax;
}

template <typename StartAndSize>
const CellDrawing::AxisPositions* CellDrawing::PositionsOf(int first, int last, int source_size,
                                                           StartAndSize start_and_size,
                                                           AxisPositionsList* list) const {
  for (size_t i = 0; i < list->count; ++i) {
    const AxisPositions* known = list->all[i].get();
    if (known->source_size == source_size) {
      return known;
    }
  }
  if (list->count == list->all.size()) {
    list->all.push_back(std::make_unique<AxisPositions>());
  }
  AxisPositions* positions = list->all[list->count++].get();
  positions->source_size = source_size;
  positions->adjoin = true;
  positions->ranges.clear();
  positions->sources.clear();
  int end = -1;  // of the last cell that has pixels
  for (int cell = first; cell <= last; ++cell) {
    const auto [start, size] = start_and_size(cell);
    const AxisSteps steps =
        StretchedSteps(start, size, source_size, frame_->size_px, FirstPosition::kTruncatedStep);
    positions->ranges.push_back(
        {steps.first, positions->sources.size(), static_cast<size_t>(steps.count)});
    if (steps.count > 0) {
      positions->adjoin &= end < 0 || steps.first == end;
      end = steps.first + steps.count;
    }
    for (int pixel = steps.first; pixel < steps.first + steps.count; ++pixel) {
      positions->sources.push_back(steps.SourceAt(pixel));
    }
  }
  return positions;
}

CellDrawing::Look CellDrawing::FindLook(int kind) {
  Look look;
  look.frame_number = frame_number_;
  const CellAppearance& cell = cells_->looks[static_cast<size_t>(kind)];
  if (cell.image_kind < 0) {
    return look;
  }
  if (style_ == ArtStyle::kMonochrome) {
    look.way = Look::Way::kFlat;
    look.color = MonochromeColor(cell.image_kind, cell.theme);
    look.opaque = true;
    return look;
  }
  look.art = style_ == ArtStyle::kGenerated ? art_->GeneratedOf(cell.image_kind, false)
                                            : art_->SpriteOf(cell.image_kind, cell.theme, false);
  look.way = Look::Way::kPicture;
  if (scales_ && look.art.picture->scales()) {
    look.way = Look::Way::kScaled;
    look.opaque = look.art.picture->opaque();
    return look;
  }
  const ScreenRect rect = viewport_->OfCell(cells_->first_column, cells_->first_row);
  const Image& image = look.art.picture->LevelFor(rect.width, rect.height);
  // An image of exactly its own size is drawn differently.
  if (look.art.generated || look.art.picture->level_count() > 1 || rect.width == image.width()) {
    return look;
  }
  look.way = Look::Way::kStretched;
  look.opaque = look.art.picture->opaque();
  look.across = PositionsOf(
      cells_->first_column, cells_->last_column, image.width(),
      [this](int x) {
        const ScreenRect cell = viewport_->OfCell(x, cells_->first_row);
        return std::pair(cell.x, cell.width);
      },
      &across_);
  look.down = PositionsOf(
      cells_->first_row, cells_->last_row, image.height(),
      [this](int y) {
        const ScreenRect cell = viewport_->OfCell(cells_->first_column, y);
        return std::pair(cell.y, cell.height);
      },
      &down_);
  return look;
}

bool CellDrawing::MayOverlapDiagonally() const {
  const auto any = [](const std::vector<PixelRange>& ranges, auto overlap) {
    return std::adjacent_find(ranges.begin(), ranges.end(), overlap) != ranges.end();
  };
  using Range = const PixelRange&;
  return any(columns_, [](Range left, Range right) { return left.end > right.first; }) &&
         any(rows_, [](Range lower, Range upper) { return upper.end > lower.first; });
}

void CellDrawing::FindCells() {
  if (MayOverlapDiagonally()) {
    FindColumnRuns();
  } else {
    FindRowRuns();
  }
}

template <typename KindAt, typename Add>
void CellDrawing::FindRunsOfLine(int first, int end, int count, KindAt kind_at, Add add) {
  const auto add_run = [&](Look* look, int from, int to) {
    if (look != nullptr && from < to) {
      add(look, from, to);
    }
  };
  Look* outside = LookOf(cells_->out_of_bounds_kind);
  add_run(outside, 0, first);
  for (int cell = first; cell < end;) {
    const int kind = kind_at(cell);
    const int begin = cell;
    do {
      ++cell;
    } while (cell < end && kind_at(cell) == kind);
    if (kind != kEmptyKind) {
      add_run(LookOf(kind), begin, cell);
    }
  }
  add_run(outside, end, count);
}

void CellDrawing::FindRowRuns() {
  const Grid& grid = *cells_->grid;
  const int count = static_cast<int>(columns_.size());
  const int first = std::clamp(-cells_->first_column, 0, count);
  const int end = std::clamp(grid.width() - cells_->first_column, first, count);
  for (int row = 0; row < static_cast<int>(rows_.size()); ++row) {
    const int y = cells_->first_row + row;
    const bool is_inside = y >= 0 && y < grid.height();
    FindRunsOfLine(
        is_inside ? first : count, is_inside ? end : count, count,
        [&](int column) { return grid.At(cells_->first_column + column, y); },
        [&](Look* look, int from, int to) {
          shown_.push_back({look, from, to, row, row + 1});
        });
  }
}

void CellDrawing::FindColumnRuns() {
  const Grid& grid = *cells_->grid;
  const int count = static_cast<int>(rows_.size());
  const int first = std::clamp(-cells_->first_row, 0, count);
  const int end = std::clamp(grid.height() - cells_->first_row, first, count);
  for (int column = 0; column < static_cast<int>(columns_.size()); ++column) {
    const int x = cells_->first_column + column;
    const bool is_inside = x >= 0 && x < grid.width();
    FindRunsOfLine(
        is_inside ? first : count, is_inside ? end : count, count,
        [&](int row) { return grid.At(x, cells_->first_row + row); },
        [&](Look* look, int from, int to) {
          shown_.push_back({look, column, column + 1, from, to});
        });
  }
}

uint64_t CellDrawing::ColumnsOf(const CellRun& run) const {
  const int count = columns_adjoin_ ? run.end_column - run.column : 1;
  uint64_t columns = 0;
  for (int column = run.column; column < run.end_column; column += count) {
    columns |= BitRange(columns_[static_cast<size_t>(column)].first,
                        columns_[static_cast<size_t>(column + count - 1)].end);
  }
  return columns;
}

void CellDrawing::AddHidden(PixelSet* hidden) {
  hidden_of_rows_.assign(rows_.size(), 0);
  for (const CellRun& run : shown_) {
    if (!run.look->opaque) {
      continue;
    }
    if (run.look->way == Look::Way::kStretched) {
      const int count = run.look->across->adjoin ? run.end_column - run.column : 1;
      uint64_t columns = 0;
      for (int column = run.column; column < run.end_column; column += count) {
        const SourcePositions across = run.look->across->At(column, column + count);
        columns |= BitRange(across.first, across.end());
      }
      for (int row = run.row; row < run.end_row; ++row) {
        const SourcePositions down = run.look->down->At(row, row + 1);
        for (int y = down.first; y < down.end(); ++y) {
          hidden->Add(y, columns);
        }
      }
      continue;
    }
    const uint64_t columns = ColumnsOf(run);
    for (int row = run.row; row < run.end_row; ++row) {
      hidden_of_rows_[static_cast<size_t>(row)] |= columns;
    }
  }
  for (size_t row = 0; row < rows_.size(); ++row) {
    const int end = std::min(rows_[row].end, frame_->size_px);
    for (int y = std::max(rows_[row].first, 0); y < end; ++y) {
      hidden->Add(y, hidden_of_rows_[row]);
    }
  }
}

void CellDrawing::Draw() {
  for (const CellRun& run : shown_) {
    switch (run.look->way) {
      case Look::Way::kNothing:
        break;
      case Look::Way::kFlat:
        DrawFlatRun(run);
        break;
      case Look::Way::kScaled:
        ForEachCell(run, [&](size_t column, size_t row) {
          DrawScaledCell(*run.look, columns_[column], rows_[row]);
        });
        break;
      case Look::Way::kStretched:
        DrawStretchedRun(run);
        break;
      case Look::Way::kPicture:
        ForEachCell(run, [&](size_t column, size_t row) {
          DrawPicture(*run.look, static_cast<int>(column), static_cast<int>(row));
        });
        break;
      case Look::Way::kDot:
        ForEachCell(
            run, [&](size_t column, size_t row) { DrawDot(dot_columns_[column], dot_rows_[row]); });
        break;
    }
  }
}

template <typename DrawCell>
void CellDrawing::ForEachCell(const CellRun& run, DrawCell draw) {
  for (int row = run.row; row < run.end_row; ++row) {
    for (int column = run.column; column < run.end_column; ++column) {
      draw(static_cast<size_t>(column), static_cast<size_t>(row));
    }
  }
}

void CellDrawing::DrawFlatRun(const CellRun& run) const {
  const int count = columns_adjoin_ ? run.end_column - run.column : 1;
  for (int row = run.row; row < run.end_row; ++row) {
    const PixelRange down = rows_[static_cast<size_t>(row)];
    for (int column = run.column; column < run.end_column; column += count) {
      FillPixels({columns_[static_cast<size_t>(column)].first, down.first,
                  columns_[static_cast<size_t>(column + count - 1)].end, down.end},
                 run.look->color, *frame_);
    }
  }
}

void CellDrawing::DrawStretchedRun(const CellRun& run) const {
  const Look& look = *run.look;
  const int count = look.across->adjoin ? run.end_column - run.column : 1;
  for (int row = run.row; row < run.end_row; ++row) {
    const SourcePositions down = look.down->At(row, row + 1);
    for (int column = run.column; column < run.end_column; column += count) {
      DrawAtPositions(look.art.picture->level(0), look.opaque,
                      look.across->At(column, column + count), down, *frame_);
    }
  }
}

void CellDrawing::DrawDot(PixelRange across, PixelRange down) const {
  FillPixels({across.first, down.first, across.end, down.end}, dot_.color, *frame_);
}

void CellDrawing::DrawPicture(const Look& look, int column, int row) const {
  const ScreenRect rect = viewport_->OfCell(cells_->first_column + column, cells_->first_row + row);
  if (look.art.generated) {
    DrawNearestGenerated(*look.art.picture, rect, 0, 1, *frame_);
  } else {
    DrawNearest(*look.art.picture, rect, 0, 1, *frame_);
  }
}

void CellDrawing::DrawScaledCell(Look& look, PixelRange across, PixelRange down) const {
  const int width = across.end - across.first;
  const int height = down.end - down.first;
  std::shared_ptr<const ScaledImage>& scaled =
      look.scaled[static_cast<size_t>(height - height_min_)]
                 [static_cast<size_t>(width - width_min_)];
  if (scaled == nullptr) {
    scaled = look.art.picture->ScaledTo({.width = width, .height = height});
  }
  DrawScaled(*scaled, across.first, down.first, kOpaque, *frame_);
}

}  // namespace procgen
