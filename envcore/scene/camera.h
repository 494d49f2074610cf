#ifndef ENVCORE_SCENE_CAMERA_H_
#define ENVCORE_SCENE_CAMERA_H_

namespace procgen {

// The part of the world that an image shows, at any size: a square of `cells` x `cells` around the
// center.
struct Camera {
  float center_x = 0;
  float center_y = 0;
  float cells = 16;

  bool operator==(const Camera&) const = default;
};

// A rectangle on the screen, in pixels, y down. A negative size swaps the edges.
struct ScreenRect {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

// A camera's view of an image of size_px x size_px pixels. Positions are computed in f32, in the
// order of the drawing rules, so that each pixel equals that of Procgen 0.10.7.
class Viewport {
 public:
  Viewport(const Camera& camera, int size_px);

  int size_px() const { return size_px_; }
  float pixels_per_cell() const { return pixels_per_cell_; }
  float cells() const { return cells_; }

  // The rectangle of a box in the world: left edge x, TOP edge y (y points up in the world),
  // enlarged by `overdraw` cells on each side.
  ScreenRect InWorld(float x, float y, float width, float height, float overdraw) const;
  // The rectangle of an entity's box.
  ScreenRect OfBox(float x, float y, float rx, float ry) const;
  // The rectangle of cell (x, y), slightly enlarged to close the gaps between cells.
  ScreenRect OfCell(int x, int y) const;
  // The rectangle of a box given in fractions of the image: center and half-sizes.
  ScreenRect OfShares(float x, float y, float rx, float ry) const;

 private:
  int size_px_;
  float pixels_per_cell_;
  float cells_;
  float offset_x_;
  float offset_y_;
};

}  // namespace procgen

#endif  // ENVCORE_SCENE_CAMERA_H_
