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

// A picture in a box, rotated around the box's centre or tiled over it.
struct Sprite {
  float x = 0;  // centre and half-sizes in cells, or in shares of the picture
  float y = 0;
  float rx = 0;
  float ry = 0;
  int16_t image_kind = 0;  // [0, kKindCount)
  int16_t theme = 0;       // already 0 where themes are restricted
  bool mirrored = false;   // flipped left-right
  bool screen_coordinates = false;
  float rotation = 0;    // radians, clockwise; 0: not rotated
  float opacity = 1;     // [0, 1]
  float tile_ratio = 0;  // > 0 tiles side by side, < 0 one below the other, each this many times as
                         // wide as high; 0 none
  // The art's rectangle in shares of the box's height: top edge moved by `art_top`, height times
  // `art_height`. Flat colours keep to the box.
  double art_top = 0;
  double art_height = 1;

  bool operator==(const Sprite&) const = default;
};

// How a kind of cell looks. Cells are never rotated, mirrored, tiled or translucent.
struct CellLook {
  int16_t image_kind = 0;  // negative: not drawn
  int16_t theme = 0;

  bool operator==(const CellLook&) const = default;
};

// A kind of cell that shows a flat square in its middle, in every art style, in place of a picture.
struct CellDots {
  int kind = kOutsideKind;                   // kOutsideKind: none
  float share = 0;                           // of the square's side in the cell's
  std::array<uint8_t, 3> color = {0, 0, 0};  // red, green, blue

  bool operator==(const CellDots&) const = default;
};

// The cells of a grid that are in view. Empty cells (kEmptyKind) are not drawn, nor are cells
// outside of the grid when their kind is kOutsideKind.
struct CellLayer {
  const Grid* grid = nullptr;  // must outlive the drawing of the scene
  int first_column = 0;        // inclusive; may lie outside of the grid
  int last_column = -1;
  int first_row = 0;
  int last_row = -1;
  int out_of_bounds_kind = kOutsideKind;
  std::array<CellLook, kKindCount> looks;  // by kind
  CellDots dots;
};

// The picture behind everything, stretched to the world's height (tile_ratio 0), tiled downward in
// squares (-1), or, if it `scrolls`, in a strip of squares three times as high as the view that
// moves to the left.
struct Background {
  bool shown = false;  // false: black
  BackgroundGroup group = BackgroundGroup::kPlatform;
  int index = 0;  // in the group; not used with `generated`
  const GeneratedArt* generated =
      nullptr;       // in place of the group's picture; must outlive the drawing of the scene
  float offset = 0;  // how far the picture is shifted to the left, in [0, 1]
  float tile_ratio = 0;
  bool scrolls = false;        // then offset and tile_ratio are not used
  int32_t scrolled_steps = 0;  // how far; 0 for one that does not scroll

  bool operator==(const Background&) const = default;
};

// Two squares in the top left corner whose grey tells the agent's velocity.
struct VelocityDisplay {
  bool shown = false;
  float vx = 0;
  float vy = 0;
  float vx_max = 1;  // shown as white
  float vy_max = 1;
};

// A flat shape over everything else: a bar, a part of a compass.
struct Overlay {
  enum class Shape : uint8_t {
    kRectangle,  // filled with `color`
    kDisc,       // an ellipse in the rectangle, filled with `color` and outlined 1 pixel wide in it
    kNeedle,     // a line in `color` from the rectangle's middle, 0.95 of its half width long
    kJumpMark,   // a translucent white ellipse under a box in the world; no `color`
  };
  Shape shape = Shape::kRectangle;
  // Cells from the picture's top left corner, y down. kJumpMark: the box's centre and half-sizes,
  // in the world.
  float x = 0;
  float y = 0;
  float width = 0;
  float height = 0;
  float angle = 0;  // of a needle, radians, counterclockwise from the right
  std::array<uint8_t, 3> color = {0, 0, 0};  // red, green, blue
};

enum class ArtStyle {
  kPictures,    // the art pack's
  kGenerated,   // made from random numbers, one picture for all themes of a kind
  kMonochrome,  // flat rectangles
};

// All that is to be seen, as data: filled by a game from its state without touching the state,
// drawn by a rasteriser at any size. Drawing order: black, background, below_cells, cells,
// above_cells, velocity. Reused from step to step: Clear keeps the memory.
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
