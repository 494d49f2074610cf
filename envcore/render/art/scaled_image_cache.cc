#include "envcore/render/art/scaled_image_cache.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

namespace procgen {
namespace {

// The source columns (or rows) that one column of the scaled image covers. Weights are integers: a
// source column is divided into as many parts as the scaled image has columns.
struct Share {
  int first = 0;
  int end = 0;
  int64_t first_weight = 0;  // of column `first`
  int64_t last_weight = 0;   // of column `end - 1`, if it is not `first`
};

Share ShareOf(int place, int source_size, int size) {
  const int64_t from = int64_t{place} * source_size;
  const int64_t to = from + source_size;
  Share share;
  share.first = static_cast<int>(from / size);
  share.end = static_cast<int>((to + size - 1) / size);
  share.first_weight = std::min<int64_t>(to, (int64_t{share.first} + 1) * size) - from;
  share.last_weight = to - (int64_t{share.end} - 1) * size;
  return share;
}

struct Sums {
  uint64_t red = 0;
  uint64_t green = 0;
  uint64_t blue = 0;
  uint64_t alpha = 0;

  template <typename Channels>
  void Add(const Channels& channels, uint64_t weight) {
    red += weight * channels.red;
    green += weight * channels.green;
    blue += weight * channels.blue;
    alpha += weight * channels.alpha;
  }
};

// Divides by the sum of all weights and rounds to the nearest integer. Multiplies instead of
// dividing: an integer division costs more than all the rest of scaling.
class Mean {
 public:
  explicit Mean(uint64_t total) : total_(total), share_(1.0 / static_cast<double>(total)) {}

  Rgba Of(const Sums& sums) const {
    return {Divide(sums.red), Divide(sums.green), Divide(sums.blue), Divide(sums.alpha)};
  }

 private:
  uint8_t Divide(uint64_t sum) const {
    const uint64_t rounded = sum + total_ / 2;
    auto quotient = static_cast<uint64_t>(static_cast<double>(rounded) * share_);
    quotient += (quotient + 1) * total_ <= rounded ? 1 : 0;
    quotient -= quotient * total_ > rounded ? 1 : 0;
    return static_cast<uint8_t>(quotient);
  }

  uint64_t total_;
  double share_;
};

// Of the places [first, end).
std::vector<Share> SharesOf(int first, int end, int source_size, int size) {
  std::vector<Share> shares;
  shares.reserve(static_cast<size_t>(end - first));
  for (int place = first; place < end; ++place) {
    shares.push_back(ShareOf(place, source_size, size));
  }
  return shares;
}

// Calls `add(place, weight)` for each source column (or row) of a share.
template <typename Add>
void ForEachPart(const Share& share, int size, Add add) {
  add(share.first, share.first_weight);
  for (int place = share.first + 1; place < share.end - 1; ++place) {
    add(place, size);
  }
  if (share.end - share.first > 1) {
    add(share.end - 1, share.last_weight);
  }
}

int64_t BytesOf(int width, int height) {
  return static_cast<int64_t>(sizeof(Rgba)) * width * height;
}

constexpr int kSamplesPerSide = 4;  // per pixel of a rotated image

// Rotates around the center by sampling.
Image ScaledRotated(const Image& source, const ScaledSize& size) {
  const double angle = 2 * std::numbers::pi * size.angle / kAngleCount;
  const double cos = std::cos(angle);
  const double sin = std::sin(angle);
  const auto side = [&](double along, double across) {
    return static_cast<int>(std::ceil(std::abs(along) + std::abs(across) - 1e-9));
  };
  Image image(side(size.width * cos, size.height * sin), side(size.width * sin, size.height * cos));
  constexpr int kSampleCount = kSamplesPerSide * kSamplesPerSide;
  const Mean mean(kSampleCount);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      Sums sums;
      for (int i = 0; i < kSampleCount; ++i) {
        const int sample_column = i % kSamplesPerSide;
        const int sample_row = i / kSamplesPerSide;
        const double dx = x + (sample_column + 0.5) / kSamplesPerSide - image.width() / 2.0;
        const double dy = y + (sample_row + 0.5) / kSamplesPerSide - image.height() / 2.0;
        const double column = ((dx * cos + dy * sin) / size.width + 0.5) * source.width();
        const double row = ((dy * cos - dx * sin) / size.height + 0.5) * source.height();
        if (column >= 0 && row >= 0 && column < source.width() && row < source.height()) {
          sums.Add(source.At(static_cast<int>(column), static_cast<int>(row)), 1);
        }
      }
      image.At(x, y) = mean.Of(sums);
    }
  }
  return image;
}

}  // namespace

Image Scaled(const Image& source, const ScaledSize& size) {
  return size.angle == 0 ? ScaledPart(source, size, {0, 0, size.width, size.height})
                         : ScaledRotated(source, size);
}

Image ScaledPart(const Image& source, const ScaledSize& size, const PixelBox& part) {
  Image image(part.width(), part.height());
  const std::vector<Share> shares = SharesOf(part.left, part.right, source.width(), size.width);
  const int first_column = shares.front().first;
  const Mean mean(static_cast<uint64_t>(source.width()) * static_cast<uint64_t>(source.height()));
  std::vector<Sums> columns(static_cast<size_t>(shares.back().end - first_column));
  for (int y = 0; y < part.height(); ++y) {
    std::fill(columns.begin(), columns.end(), Sums());
    ForEachPart(ShareOf(part.top + y, source.height(), size.height), size.height,
                [&](int row, int64_t weight) {
                  const Rgba* pixels = source.Row(row) + first_column;
                  for (size_t x = 0; x < columns.size(); ++x) {
                    columns[x].Add(pixels[x], static_cast<uint64_t>(weight));
                  }
                });
    for (int x = 0; x < part.width(); ++x) {
      Sums sums;
      ForEachPart(shares[static_cast<size_t>(x)], size.width, [&](int column, int64_t weight) {
        sums.Add(columns[static_cast<size_t>(column - first_column)],
                 static_cast<uint64_t>(weight));
      });
      image.At(x, y) = mean.Of(sums);
    }
  }
  return image;
}

void Harden(Image* image) {
  Rgba* const begin = image->Row(0);
  Rgba* const end = begin + static_cast<ptrdiff_t>(image->width()) * image->height();
  const uint32_t alpha_max = std::max_element(begin, end, [](const Rgba& a, const Rgba& b) {
                               return a.alpha < b.alpha;
                             })->alpha;
  for (Rgba* pixel = begin; pixel != end; ++pixel) {
    const uint32_t alpha = pixel->alpha;
    if (alpha == alpha_max) {
      continue;
    }
    if (alpha * 3 < alpha_max) {
      *pixel = {};
      continue;
    }
    const auto full = [&](uint8_t channel) {
      return static_cast<uint8_t>(std::min(alpha_max, (channel * alpha_max + alpha / 2) / alpha));
    };
    *pixel = {full(pixel->red), full(pixel->green), full(pixel->blue),
              static_cast<uint8_t>(alpha_max)};
  }
}

ScaledImageCache::~ScaledImageCache() {
  for (std::atomic<const Entry*>& bucket : buckets_) {
    for (const Entry* entry = bucket; entry != nullptr;) {
      const std::unique_ptr<const Entry> owned(entry);
      entry = entry->next;
    }
  }
}

ScaledImageCache::Bucket& ScaledImageCache::BucketOf(const ScaledSize& size) const {
  return buckets_[static_cast<size_t>(size.width + 5 * size.height + 11 * size.angle) %
                  buckets_.size()];
}

const ScaledImageCache::Entry* ScaledImageCache::FindIn(const Entry* first, const Entry* end,
                                                        const ScaledSize& size) {
  for (const Entry* entry = first; entry != end; entry = entry->next) {
    if (entry->size == size) {
      return entry;
    }
  }
  return nullptr;
}

const ScaledImage* ScaledImageCache::Find(const ScaledSize& size) const {
  const Entry* entry = FindIn(BucketOf(size).load(std::memory_order_acquire), nullptr, size);
  return entry == nullptr ? nullptr : &entry->picture;
}

bool ScaledImageCache::HasRoomFor(const ScaledSize& size) const {
  return kept_bytes_.load(std::memory_order_relaxed) + BytesOf(size.width, size.height) <=
         kKeptBytesMax;
}

std::shared_ptr<const ScaledImage> ScaledImageCache::Make(const Image& source,
                                                          const ScaledSize& size) const {
  auto made = std::make_unique<Entry>();
  made->size = size;
  made->picture.image = Scaled(source, size);
  Harden(&made->picture.image);
  made->picture.opaque = IsOpaque(made->picture.image);
  const int64_t bytes = BytesOf(made->picture.image.width(), made->picture.image.height());
  if (kept_bytes_.fetch_add(bytes, std::memory_order_relaxed) + bytes > kKeptBytesMax) {
    kept_bytes_.fetch_sub(bytes, std::memory_order_relaxed);
    return std::make_shared<const ScaledImage>(std::move(made->picture));
  }
  Bucket& bucket = BucketOf(size);
  const Entry* head = bucket.load(std::memory_order_acquire);
  const Entry* seen = nullptr;
  do {
    if (const Entry* entry = FindIn(head, seen, size)) {
      kept_bytes_.fetch_sub(bytes, std::memory_order_relaxed);
      return Unowned(entry->picture);
    }
    seen = head;
    made->next = head;
  } while (!bucket.compare_exchange_weak(head, made.get(), std::memory_order_acq_rel,
                                         std::memory_order_acquire));
  return Unowned(made.release()->picture);
}

}  // namespace procgen
