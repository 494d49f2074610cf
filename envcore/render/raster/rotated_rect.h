#ifndef ENVCORE_RENDER_RASTER_ROTATED_RECT_H_
#define ENVCORE_RENDER_RASTER_ROTATED_RECT_H_

#include <array>

#include "envcore/render/raster/curve.h"
#include "envcore/scene/camera.h"

namespace procgen {

// A rectangle rotated around its center, clockwise on the screen.
class RotatedRect {
 public:
  // `rotation`: radians. Quarter and half turns, to the precision of f32, are exact.
  RotatedRect(const ScreenRect& rect, float rotation);

  double sin() const { return sin_; }
  double cos() const { return cos_; }
  Point center() const { return center_; }
  const ScreenRect& unrotated() const { return rect_; }

  // Whether it is not rotated, or rotated by exactly a half turn.
  bool IsUpright() const { return IsLevel() && cos_ > 0; }
  bool IsHalfTurn() const { return IsLevel() && cos_ < 0; }

  // Maps the point (a, b) of the rectangle (-width / 2, -height / 2, width, height) to the screen.
  Point Map(double a, double b) const;
  // The corners on the screen: the unrotated top left, top right, bottom right, bottom left.
  std::array<Point, 4> Corners() const;

 private:
  bool IsLevel() const;

  ScreenRect rect_;
  Point center_;
  double sin_ = 0;
  double cos_ = 1;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_ROTATED_RECT_H_
