#ifndef ENVCORE_SCENE_SCENE_H_
#define ENVCORE_SCENE_SCENE_H_

#include <array>
#include <cstdint>
#include <vector>

#include "envcore/level/generated_art.h"
#include "envcore/scene/art_slot.h"
#include "envcore/scene/camera.h"
#include "envcore/world/grid.h"
#include "envcore/world/kinds.h"

namespace procgen {

// An image in a box, rotated around the center of the box or tiled over it.
struct Sprite {
  float x = 0;  // center and half-sizes, in cells or (screen_coordinates) in fractions of the image
  float y = 0;
  float rx = 0;
  float ry = 0;
  int16_t image_kind = 0;  // [0, kKindCount)
  int16_t theme = 0;       // already 0 if themes are restricted
  bool mirrored = false;   // flipped left-right
  bool screen_coordinates = false;
  float rotation = 0;    // radians, clockwise; 0: not rotated
  float opacity = 1;     // [0, 1]
  float tile_ratio = 0;  // > 0: tiles side by side; < 0: tiles one below the other; each tile is
                         // this many times as wide as high; 0: no tiles
  // The image's rectangle, in fractions of the box's height: the top edge moved by `art_top`, the
  // height times `art_height`. Flat colors fill the box.
  double art_top = 0;
  double art_height = 1;

  bool operator==(const Sprite&) const = default;
};

// The look of a kind of cell. Cells are never rotated, mirrored, tiled or translucent.
struct CellAppearance {
  int16_t image_kind = 0;  // negative: not drawn
  int16_t theme = 0;

  bool operator==(const CellAppearance&) const = default;
};

// A kind of cell that shows a flat square in its center instead of an image, in every art style.
struct CellDots {
  int kind = kOutsideKind;                   // kOutsideKind: none
  float share = 0;                           // side of the square / side of the cell
  std::array<uint8_t, 3> color = {0, 0, 0};  // red, green, blue

  bool operator==(const CellDots&) const = default;
};

// The cells of a grid that are in view. Empty cells (kEmptyKind) are not drawn, nor are cells
// outside the grid if out_of_bounds_kind is kOutsideKind.
struct CellLayer {
  const Grid* grid = nullptr;  // must outlive the drawing of the scene
  int first_column = 0;        // inclusive; may be outside the grid
  int last_column = -1;
  int first_row = 0;
  int last_row = -1;
  int out_of_bounds_kind = kOutsideKind;
  std::array<CellAppearance, kKindCount> looks;  // by kind
  CellDots dots;
};

// The image behind everything. With tile_ratio 0 it is stretched to the world's height; with -1 it
// is tiled downward in squares. With `scrolls` it is a strip of squares, three times as high as the
// view, that moves to the left.
struct Background {
  bool shown = false;  // false: black
  BackgroundGroup group = BackgroundGroup::kPlatform;
  int index = 0;  // in the group; unused with `generated`
  const GeneratedArt* generated =
      nullptr;       // instead of the group's image; must outlive the drawing of the scene
  float offset = 0;  // shift to the left, in [0, 1]
  float tile_ratio = 0;
  bool scrolls = false;        // then offset and tile_ratio are unused
  int32_t scrolled_steps = 0;  // distance of the scrolling; 0 without `scrolls`

  bool operator==(const Background&) const = default;
};

// Two squares in the top left corner whose gray level shows the agent's velocity.
struct VelocityDisplay {
  bool shown = false;
  float vx = 0;
  float vy = 0;
  float vx_max = 1;  // shown as white
  float vy_max = 1;
};

// A flat shape on top of everything else: a bar, or a part of a compass.
struct Overlay {
  enum class Shape : uint8_t {
    kRectangle,  // filled with `color`
    kDisc,       // ellipse in the rectangle, filled with `color`, with a 1 pixel outline in it
    kNeedle,     // line in `color` from the rectangle's center, 0.95 of half its width long
    kJumpMark,   // translucent white ellipse under a box in the world; ignores `color`
  };
  Shape shape = Shape::kRectangle;
  // Cells from the top left corner of the image, y down. kJumpMark: center and half-sizes of the
  // box in the world.
  float x = 0;
  float y = 0;
  float width = 0;
  float height = 0;
  float angle = 0;  // of the needle, in radians, counterclockwise from the right
  std::array<uint8_t, 3> color = {0, 0, 0};  // red, green, blue
};

enum class ArtStyle {
  kPictures,    // images of the art pack
  kGenerated,   // made from random numbers; one image for all themes of a kind
  kMonochrome,  // flat rectangles
};

// A frame as data. A game fills it from its state without changing the state; a rasteriser draws it
// at any size. Drawing order: black, background, below_cells, cells, above_cells, velocity,
// overlays. Reused from step to step; Clear keeps the memory.
struct Scene {
  Camera camera;
  int world_width = 0;  // cells
  int world_height = 0;
  ArtStyle art_style = ArtStyle::kPictures;
  Background background;
  std::vector<Sprite> below_cells;
  CellLayer cells;
  std::vector<Sprite> above_cells;
  VelocityDisplay velocity;
  std::vector<Overlay> overlays;

  void Clear() {
    below_cells.clear();
    above_cells.clear();
    overlays.clear();
  }
};

}  // namespace procgen

#endif  // ENVCORE_SCENE_SCENE_H_
