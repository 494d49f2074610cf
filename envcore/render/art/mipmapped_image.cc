#include "envcore/render/art/mipmapped_image.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace procgen {
namespace {

// Half the size, rounded up; each pixel is the mean of the 2 x 2 pixels that it replaces.
Image Halved(const Image& image) {
  Image half((image.width() + 1) / 2, (image.height() + 1) / 2);
  for (int y = 0; y < half.height(); ++y) {
    const Rgba* upper = image.Row(2 * y);
    const Rgba* lower = image.Row(std::min(2 * y + 1, image.height() - 1));
    for (int x = 0; x < half.width(); ++x) {
      const int left = 2 * x;
      const int right = std::min(2 * x + 1, image.width() - 1);
      const auto mean = [&](uint8_t Rgba::*channel) {
        const int sum = upper[left].*channel + upper[right].*channel + lower[left].*channel +
                        lower[right].*channel;
        return static_cast<uint8_t>((sum + 2) / 4);
      };
      half.At(x, y) = {mean(&Rgba::red), mean(&Rgba::green), mean(&Rgba::blue), mean(&Rgba::alpha)};
    }
  }
  return half;
}

}  // namespace

MipmappedImage::MipmappedImage(Image image, Levels levels) {
  if (image.empty()) {
    return;
  }
  opaque_ = IsOpaque(image);
  levels_.push_back(std::move(image));
  if (levels == Levels::kAll) {
    while (levels_.back().width() > 1 || levels_.back().height() > 1) {
      levels_.push_back(Halved(levels_.back()));
    }
    scaled_ = std::make_unique<ScaledImageCache>();
  } else {
    column_copies_ = std::make_unique<ColumnCopies>();
  }
}

const Image& MipmappedImage::LevelFor(double width_px, double height_px) const {
  size_t level = 0;
  while (level + 1 < levels_.size() && levels_[level + 1].width() >= width_px &&
         levels_[level + 1].height() >= height_px) {
    ++level;
  }
  return levels_[level];
}

std::shared_ptr<const ScaledImage> MipmappedImage::ScaledTo(const ScaledSize& size) const {
  const ScaledImage* scaled = scaled_->Find(size);
  return scaled != nullptr ? Unowned(*scaled)
                           : scaled_->Make(LevelFor(size.width, size.height), size);
}

std::shared_ptr<const ScaledImage> MipmappedImage::KeptAt(const ScaledSize& size) const {
  const ScaledImage* scaled = scaled_->Find(size);
  if (scaled != nullptr) {
    return Unowned(*scaled);
  }
  return scaled_->HasRoomFor(size) ? scaled_->Make(LevelFor(size.width, size.height), size)
                                   : nullptr;
}

Image MipmappedImage::PartAt(const ScaledSize& size, const PixelBox& part) const {
  return ScaledPart(LevelFor(size.width, size.height), size, part);
}

MipmappedImage MipmappedImage::Mirrored() const {
  MipmappedImage mirrored;
  mirrored.opaque_ = opaque_;
  mirrored.levels_ = levels_;
  for (Image& image : mirrored.levels_) {
    for (int y = 0; y < image.height(); ++y) {
      std::reverse(image.Row(y), image.Row(y) + image.width());
    }
  }
  if (scaled_ != nullptr) {
    mirrored.scaled_ = std::make_unique<ScaledImageCache>();
  } else {
    mirrored.column_copies_ = std::make_unique<ColumnCopies>();
  }
  return mirrored;
}

}  // namespace procgen
