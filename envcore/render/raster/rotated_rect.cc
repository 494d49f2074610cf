#include "envcore/render/raster/rotated_rect.h"

#include <cmath>
#include <numbers>

namespace procgen {
namespace {

constexpr double kLevelSine = 1e-12;
constexpr double kRadiansPerDegree = 0.017453292519943295769;

}  // namespace

RotatedRect::RotatedRect(const ScreenRect& rect, float rotation)
    : rect_(rect), center_{rect.x + rect.width / 2, rect.y + rect.height / 2} {
  const float degrees_f32 = (rotation * 180.0F) / std::numbers::pi_v<float>;
  const auto degrees = static_cast<double>(degrees_f32);
  if (degrees == 90 || degrees == -270) {
    sin_ = 1;
    cos_ = 0;
  } else if (degrees == 270 || degrees == -90) {
    sin_ = -1;
    cos_ = 0;
  } else if (degrees == 180) {
    sin_ = 0;
    cos_ = -1;
  } else {
    const double radians = degrees * kRadiansPerDegree;
    sin_ = std::sin(radians);
    cos_ = std::cos(radians);
  }
}

bool RotatedRect::IsLevel() const { return std::abs(sin_) <= kLevelSine; }

Point RotatedRect::Map(double a, double b) const {
  return {a * cos_ - b * sin_ + center_.x, a * sin_ + b * cos_ + center_.y};
}

std::array<Point, 4> RotatedRect::Corners() const {
  const double left = -rect_.width / 2;
  const double top = -rect_.height / 2;
  const double right = left + rect_.width;
  const double bottom = top + rect_.height;
  return {Map(left, top), Map(right, top), Map(right, bottom), Map(left, bottom)};
}

}  // namespace procgen
