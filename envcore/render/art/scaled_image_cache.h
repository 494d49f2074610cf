#ifndef ENVCORE_RENDER_ART_SCALED_IMAGE_CACHE_H_
#define ENVCORE_RENDER_ART_SCALED_IMAGE_CACHE_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// Number of angles in a full turn for which rotated images are kept.
inline constexpr int kAngleCount = 64;

// An image of exactly the size that it is drawn at.
struct ScaledImage {
  Image image;
  bool opaque = false;  // every pixel is opaque
};

// The size and angle of an image on the screen.
struct ScaledSize {
  int width = 0;  // pixels, before rotation
  int height = 0;
  int angle = 0;  // clockwise, in [0, kAngleCount), in parts of a full turn

  bool operator==(const ScaledSize&) const = default;
};

// Wraps an image that outlives all its users. Holding the result costs no reference count.
inline std::shared_ptr<const ScaledImage> Unowned(const ScaledImage& picture) {
  return {std::shared_ptr<const ScaledImage>(), &picture};
}

// Returns `source` at another size; each pixel is the rounded mean of the source area it covers. A
// rotated image is large enough for its corners. REQUIRES: width, height > 0; the source is not
// empty.
Image Scaled(const Image& source, const ScaledSize& size);
// Returns the pixels `part` of Scaled(source, size). REQUIRES: as Scaled; size.angle is 0; `part`
// is inside the scaled image and not empty.
Image ScaledPart(const Image& source, const ScaledSize& size, const PixelBox& part);

// Replaces soft edges by hard ones, so that a sprite of few pixels does not fade into its
// background. A pixel with less than a third of the image's largest alpha becomes transparent; any
// other gets that alpha and keeps its color. REQUIRES: the image is not empty.
void Harden(Image* image);

// The scaled and rotated copies of one image, with hard edges. Each is made once and kept, up to
// kKeptBytesMax: enough for some dozens of sizes of a sprite at all angles, and for a background in
// the worlds of most games. Copies beyond that are made for each use: what is drawn never depends
// on what is kept.
// Threads: thread-safe; Find takes no lock.
class ScaledImageCache {
 public:
  // Sprites and cells larger than this are not kept.
  static constexpr int kSizePxMax = 32;
  // Limit of the pixels that are kept, in bytes.
  static constexpr int64_t kKeptBytesMax = 4 << 20;

  ScaledImageCache() = default;
  ~ScaledImageCache();
  ScaledImageCache(const ScaledImageCache&) = delete;
  ScaledImageCache& operator=(const ScaledImageCache&) = delete;

  // Returns the copy of this size, or null if it is not kept. It lives as long as this object.
  const ScaledImage* Find(const ScaledSize& size) const;
  // Whether an unrotated copy of this size could be kept now.
  bool HasRoomFor(const ScaledSize& size) const;
  // Makes a copy from `source`, unless another thread made it first. The result is kept and lives
  // as long as this object, or it is owned by the caller.
  std::shared_ptr<const ScaledImage> Make(const Image& source, const ScaledSize& size) const;

 private:
  struct Entry {
    ScaledSize size;
    ScaledImage picture;
    const Entry* next = nullptr;
  };
  using Bucket = std::atomic<const Entry*>;

  Bucket& BucketOf(const ScaledSize& size) const;
  static const Entry* FindIn(const Entry* first, const Entry* end, const ScaledSize& size);

  // Lock-free chains that only grow, at their heads.
  mutable std::array<Bucket, 64> buckets_ = {};
  mutable std::atomic<int64_t> kept_bytes_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_SCALED_IMAGE_CACHE_H_
