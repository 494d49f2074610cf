#ifndef ENVCORE_RENDER_ART_MIPMAPPED_IMAGE_H_
#define ENVCORE_RENDER_ART_MIPMAPPED_IMAGE_H_

#include <memory>
#include <vector>

#include "envcore/render/art/scaled_image_cache.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// Whether a picture is also kept reduced.
enum class Levels {
  kOne,  // as it is, whatever size it is drawn at: the art of Procgen 0.10.7, generated art
  kAll,  // also at half, a quarter, ... of its size, and scaled, so that few pixels still show what
         // it is
};

// A picture at one or more sizes: level 0 as it is, each further level half the size of the one
// before (rounded up), averaged, down to 1 x 1. Immutable after it was made.
// Threads: any method from any thread.
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
  // The smallest level that is at least width_px wide and height_px high, level 0 if none is.
  // REQUIRES: !empty().
  const Image& LevelFor(double width_px, double height_px) const;

  // Whether it may be shown scaled (Levels::kAll) in place of pixel by pixel.
  bool scales() const { return scaled_ != nullptr; }
  // The picture in exactly that many pixels. This must live as long as what is returned.
  // REQUIRES: scales(); 1 <= width, height.
  std::shared_ptr<const ScaledImage> ScaledTo(const ScaledSize& size) const;
  // The same, but null where it would not be kept, as too much is kept already: for large ones.
  std::shared_ptr<const ScaledImage> KeptAt(const ScaledSize& size) const;

  // The picture with its columns reversed, at all its levels.
  MipmappedImage Mirrored() const;

 private:
  std::vector<Image> levels_;
  std::unique_ptr<ScaledImageCache> scaled_;  // null: one level only
  bool opaque_ = false;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_MIPMAPPED_IMAGE_H_
