#ifndef ENVCORE_WORLD_ENTITY_H_
#define ENVCORE_WORLD_ENTITY_H_

#include <cmath>

namespace procgen {

// A box with a center and half-sizes, in cells, and its state. Velocities are in cells per step.
struct Entity {
  float x = 0;  // center
  float y = 0;
  float vx = 0;  // velocity
  float vy = 0;
  float rx = 0;  // half-sizes
  float ry = 0;
  int kind = 0;                 // selects the rules
  int image_kind = 0;           // selects the image
  int theme = 0;                // index of the image among those of the image kind
  int layer = 0;                // -1: below the cells; 0 and 1: above them; others are not drawn
  bool marked = false;          // is removed at the next removal
  bool meets_entities = false;  // takes the active part in contacts with other entities
  float contact_margin = 0;     // added to the sum of the half-sizes in contact tests
  float rotation = 0;           // radians, clockwise on the screen
  float spin = 0;               // added to the rotation each step
  bool mirrored = false;        // image flipped left-right
  int shot_step = -1;           // for the game's use
  int spawn_step = -1;          // for the game's use
  int life_time = 0;            // age in steps
  int expiry = -1;              // > 0: marked once life_time > expiry
  bool screen_coordinates = false;  // the box is in fractions of the image
  float friction = 1;               // factor on the velocity per step
  bool smart = false;               // moves with collision detection and can touch cells
  bool avoids_collisions = false;   // ignored by the overlap test of placing
  bool auto_remove = true;          // removed when outside the world
  float opacity = 1;
  float health = 1;
  float angle = -100;       // for the game's use
  float growth = 1;         // factor on both half-sizes per step
  float fading = 1;         // factor on the opacity per step
  float patrol_center = 0;  // for the game's use

  // Makes an entity with the initial values of its kind. Explosions and trails grow, fade and
  // expire.
  static Entity Make(int kind, float x, float y, float vx, float vy, float rx, float ry);

  // Updates the entity once per step, after smart motion: moves it (unless smart), rotates it,
  // slows it down, ages, grows and fades it.
  void Step();
};

// Whether the boxes overlap, with `margin` added to the sum of the half-sizes. Boxes that only
// touch do not overlap.
inline bool Overlap(const Entity& a, const Entity& b, float margin) {
  return std::fabs(a.x - b.x) < (a.rx + b.rx) + margin &&
         std::fabs(a.y - b.y) < (a.ry + b.ry) + margin;
}

}  // namespace procgen

#endif  // ENVCORE_WORLD_ENTITY_H_
