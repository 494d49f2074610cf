#ifndef ENVCORE_RENDER_ART_MIPMAPPED_IMAGE_H_
#define ENVCORE_RENDER_ART_MIPMAPPED_IMAGE_H_

#include <memory>
#include <vector>

#include "envcore/render/art/column_copies.h"
#include "envcore/render/art/scaled_image_cache.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// Which mipmap levels of an image are kept.
enum class Levels {
  kOne,  // full size only: the art of Procgen 0.10.7, and generated art
  kAll,  // also half, a quarter ... of the size, and scaled copies, so that small sprites stay
         // legible
};

// An image at one or more sizes. Level 0 is full size; each further level is half the size of the
// one before (rounded up), averaged, down to 1 x 1. Immutable.
// Threads: thread-safe.
class MipmappedImage {
 public:
  MipmappedImage() = default;
  MipmappedImage(Image image, Levels levels);

  bool empty() const { return levels_.empty(); }
  // Whether every pixel is opaque.
  bool opaque() const { return opaque_; }
  int level_count() const { return static_cast<int>(levels_.size()); }
  // REQUIRES: 0 <= level < level_count().
  const Image& level(int level) const { return levels_[static_cast<size_t>(level)]; }
  // The smallest level that is at least width_px wide and height_px high; level 0 if there is none.
  // REQUIRES: !empty().
  const Image& LevelFor(double width_px, double height_px) const;

  // Whether the image may be drawn from scaled copies (Levels::kAll) instead of pixel by pixel.
  bool scales() const { return scaled_ != nullptr; }
  // Returns the image scaled to exactly `size`. This object must outlive the result.
  // REQUIRES: scales(); 1 <= width, height.
  std::shared_ptr<const ScaledImage> ScaledTo(const ScaledSize& size) const;
  // Like ScaledTo, but returns null if the copy would not be kept because the cache is full.
  std::shared_ptr<const ScaledImage> KeptAt(const ScaledSize& size) const;
  // Returns the pixels `part` of ScaledTo(size), for images that KeptAt does not return.
  // REQUIRES: as ScaledTo; size.angle is 0; `part` is inside the scaled image and not empty.
  Image PartAt(const ScaledSize& size, const PixelBox& part) const;

  // Copies of the columns of level 0; null if there are other levels. REQUIRES: !empty().
  const ColumnCopies* column_copies() const { return column_copies_.get(); }

  // Returns the image with its columns reversed, at all levels.
  MipmappedImage Mirrored() const;

 private:
  std::vector<Image> levels_;
  std::unique_ptr<ScaledImageCache> scaled_;     // null: one level only
  std::unique_ptr<ColumnCopies> column_copies_;  // null: several levels, or empty
  bool opaque_ = false;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_MIPMAPPED_IMAGE_H_
