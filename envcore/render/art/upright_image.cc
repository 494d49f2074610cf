#include "envcore/render/art/upright_image.h"

#include <algorithm>
#include <array>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "envcore/render/raster/axis_steps.h"

namespace procgen {
namespace {

constexpr uint32_t kOpaque = 255;

// How source pixels are combined with the frame.
enum class Mix { kCopy, kLayOver, kLayOverFaded };

#if defined(__x86_64__)

// Copies eight pixels at a time.
__attribute__((target("avx2"))) int CopyByEights(const Rgba* source, const int32_t* columns,
                                                 int count, Rgba* pixel) {
  int i = 0;
  for (; i + 8 <= count; i += 8) {
    const __m256i places = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(columns + i));
    const __m256i pixels =
        _mm256_i32gather_epi32(reinterpret_cast<const int*>(source), places, sizeof(Rgba));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(pixel + i), pixels);
  }
  return i;
}

#endif

// Copies as many pixels as SIMD allows and returns how many.
int CopyMany(const Rgba* source, const int32_t* columns, int count, Rgba* pixel) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    return CopyByEights(source, columns, count, pixel);
  }
#endif
  return 0;
}

template <Mix kMix>
void DrawRow(const Rgba* source, const int32_t* columns, int count, uint32_t opacity, Rgba* pixel) {
  const int done = kMix == Mix::kCopy ? CopyMany(source, columns, count, pixel) : 0;
  pixel += done;
  for (int i = done; i < count; ++i, ++pixel) {
    const Rgba& shown = source[columns[i]];
    if (kMix == Mix::kCopy || (kMix == Mix::kLayOver && shown.alpha == kOpaque)) {
      *pixel = shown;
    } else if constexpr (kMix == Mix::kLayOverFaded) {
      BlendOver(Mul(shown, opacity), *pixel);
    } else if (shown.alpha != 0) {
      BlendOver(shown, *pixel);
    }
  }
}

// The sources of the pixels of one axis.
class Sources {
 public:
  explicit Sources(const AxisSteps& steps) : first_(steps.first), count_(steps.count) {
    for (int i = 0; i < steps.count; ++i) {
      sources_[static_cast<size_t>(i)] = steps.SourceAt(steps.first + i);
    }
  }

  SourcePositions positions() const {
    return {first_, absl::MakeConstSpan(sources_).first(static_cast<size_t>(count_))};
  }

 private:
  int first_;
  int count_;
  std::array<int32_t, kFrameSizePxMax> sources_;  // NOLINT: [0, count_) is written
};

template <Mix kMix>
void DrawRows(const Image& image, uint32_t opacity, const SourcePositions& across,
              const SourcePositions& down, const Frame& frame) {
  const auto width = static_cast<int>(across.sources.size());
  int row = down.first;
  for (const int32_t source_row : down.sources) {
    DrawRow<kMix>(image.Row(source_row), across.sources.data(), width, opacity,
                  frame.At(across.first, row++));
  }
}

void DrawMixed(const Image& image, Mix mix, uint32_t opacity, const SourcePositions& across,
               const SourcePositions& down, const Frame& frame) {
  if (across.sources.empty() || down.sources.empty()) {
    return;
  }
  switch (mix) {
    case Mix::kCopy:
      DrawRows<Mix::kCopy>(image, opacity, across, down, frame);
      break;
    case Mix::kLayOver:
      DrawRows<Mix::kLayOver>(image, opacity, across, down, frame);
      break;
    case Mix::kLayOverFaded:
      DrawRows<Mix::kLayOverFaded>(image, opacity, across, down, frame);
      break;
  }
}

void DrawStepped(const Image& image, Mix mix, uint32_t opacity, const AxisSteps& across,
                 const AxisSteps& down, const Frame& frame) {
  const Sources columns(across);
  const Sources rows(down);
  DrawMixed(image, mix, opacity, columns.positions(), rows.positions(), frame);
}

struct StepsOfBoth {
  AxisSteps across;
  AxisSteps down;
};

StepsOfBoth StepsFor(const Image& image, FirstPosition first_position, const ScreenRect& rect,
                     int size_px) {
  if (rect.width == image.width() && rect.height == image.height()) {
    return {CopiedSteps(rect.x, image.width(), size_px),
            CopiedSteps(rect.y, image.height(), size_px)};
  }
  return {StretchedSteps(rect.x, rect.width, image.width(), size_px, first_position),
          StretchedSteps(rect.y, rect.height, image.height(), size_px, first_position)};
}

Mix MixFor(bool opaque, uint32_t opacity) {
  if (opacity != kOpaque) {
    return Mix::kLayOverFaded;
  }
  return opaque ? Mix::kCopy : Mix::kLayOver;
}

FirstPosition FirstPositionFor(uint32_t opacity) {
  return opacity == kOpaque ? FirstPosition::kTruncatedStep : FirstPosition::kExactStep;
}

// A background has megabytes and its rows are read once a frame: they are fetched into the cache
// ahead. The benefit is the same for 3 to 8 rows.
constexpr int kRowsAhead = 4;
constexpr int64_t kPixelsPerCacheLine = 64 / sizeof(Rgba);

// Smallest number of columns whose sources span a cache line; at least 1.
int ColumnsPerCacheLine(const AxisSteps& across) {
  return static_cast<int>(
      std::max<int64_t>(1, (kPixelsPerCacheLine << 16) / std::max<int64_t>(1, across.step)));
}

void PrefetchRow(const Rgba* source, absl::Span<const int32_t> columns, int stride) {
  for (size_t i = 0; i < columns.size(); i += static_cast<size_t>(stride)) {
    __builtin_prefetch(source + columns[i]);
  }
  __builtin_prefetch(source + columns.back());
}

// The smallest step for which copies of columns have fewer cache lines, in 16.16 fixed point.
constexpr int64_t kCopiedStepMin = 2 << 16;
constexpr int64_t kFractionUnit = 256;  // in 16.16 fixed point

// The copy in which a background is looked for.
struct CopiedPart {
  // Whether the copy shows exactly the columns `sources`.
  bool Shows(absl::Span<const int32_t> sources) const {
    if (first_column + static_cast<int>(sources.size()) > part.width) {
      return false;
    }
    int64_t position = part.position + first_column * part.step;
    bool same = true;
    for (const int32_t source : sources) {
      same &= source == position >> 16;
      position += part.step;
    }
    return same;
  }

  ColumnCopies::Part part;
  int first_column;  // of the copy: the first one that is shown
};

CopiedPart CopiedPartOf(const Image& image, BackdropMotion motion, const AxisSteps& across,
                        const AxisSteps& down) {
  if (motion == BackdropMotion::kAny) {
    return {{.position = across.position,
             .step = across.step,
             .width = across.count,
             .first_row = 0,
             .end_row = image.height()},
            0};
  }
  // All columns that come into view with about the same fraction of a step: rounding errors make
  // small differences.
  const int64_t steps = across.position / across.step;
  const int64_t fraction = across.position - steps * across.step;
  const int64_t position = (fraction + kFractionUnit / 2) / kFractionUnit * kFractionUnit;
  const int64_t limit = (static_cast<int64_t>(image.width()) << 16) - 1;
  return {{.position = position,
           .step = across.step,
           .width = static_cast<int>((limit - position) / across.step + 1),
           .first_row = down.SourceAt(down.first),
           .end_row = down.SourceAt(down.first + down.count - 1) + 1},
          static_cast<int>(steps)};
}

}  // namespace

void DrawAtPositions(const Image& image, bool opaque, const SourcePositions& across,
                     const SourcePositions& down, const Frame& frame) {
  DrawMixed(image, MixFor(opaque, kOpaque), kOpaque, across, down, frame);
}

void DrawUpright(const Image& image, bool opaque, uint32_t opacity, const ScreenRect& rect,
                 const Frame& frame) {
  const StepsOfBoth steps = StepsFor(image, FirstPositionFor(opacity), rect, frame.size_px);
  DrawStepped(image, MixFor(opaque, opacity), opacity, steps.across, steps.down, frame);
}

void DrawHalfTurn(const Image& image, bool opaque, uint32_t opacity, const RotatedRect& rotated,
                  const Frame& frame) {
  const std::array<Point, 4> corners = rotated.Corners();
  const Point& top_left = corners[2];
  const double width = corners[0].x - top_left.x;
  const double height = corners[0].y - top_left.y;
  const FirstPosition first_position = FirstPositionFor(opacity);
  DrawStepped(image, MixFor(opaque, opacity), opacity,
              ReversedSteps(top_left.x, width, image.width(), frame.size_px, first_position),
              ReversedSteps(top_left.y, height, image.height(), frame.size_px, first_position),
              frame);
}

void DrawBackdrop(const Image& image, const ScreenRect& rect, BackdropMotion motion,
                  const ColumnCopies* copies, BackdropPixels* pixels, const Frame& frame) {
  const StepsOfBoth steps = StepsFor(image, FirstPosition::kExactStep, rect, frame.size_px);
  const AxisSteps& across = steps.across;
  const AxisSteps& down = steps.down;
  if (across.count <= 0 || down.count <= 0) {
    return;
  }
  const PixelBox box = {across.first, down.first, across.first + across.count,
                        down.first + down.count};
  const Sources columns(across);
  const absl::Span<const int32_t> sources = columns.positions().sources;
  if (copies != nullptr && across.step >= kCopiedStepMin) {
    const CopiedPart copied = CopiedPartOf(image, motion, across, down);
    const Image* copy = motion == BackdropMotion::kAny || copied.Shows(sources)
                            ? copies->Find(image, copied.part)
                            : nullptr;
    if (copy != nullptr) {
      ForEachRunToDraw(box, pixels, [&](int row, int first, int end) {
        const Rgba* source = copy->Row(down.SourceAt(row) - copied.part.first_row) +
                             (copied.first_column + first - across.first);
        std::copy(source, source + (end - first), frame.At(first, row));
      });
      return;
    }
  }
  const int stride = ColumnsPerCacheLine(across);
  ForEachRunToDraw(box, pixels, [&](int row, int first, int end) {
    const auto skipped = static_cast<size_t>(first - across.first);
    const absl::Span<const int32_t> run =
        sources.subspan(skipped, static_cast<size_t>(end - first));
    if (row + kRowsAhead < box.bottom) {
      PrefetchRow(image.Row(down.SourceAt(row + kRowsAhead)), run, stride);
    }
    DrawRow<Mix::kCopy>(image.Row(down.SourceAt(row)), run.data(), end - first, kOpaque,
                        frame.At(first, row));
  });
}

}  // namespace procgen
