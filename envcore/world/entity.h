#ifndef ENVCORE_WORLD_ENTITY_H_
#define ENVCORE_WORLD_ENTITY_H_

#include <cmath>

namespace procgen {

// A box with a centre and half-sizes, in cells, and all that the rules remember of it. Velocities
// are in cells a step.
struct Entity {
  float x = 0;  // centre
  float y = 0;
  float vx = 0;  // velocity
  float vy = 0;
  float rx = 0;  // half-sizes
  float ry = 0;
  int kind = 0;                     // selects the rules
  int image_kind = 0;               // selects the picture
  int theme = 0;                    // which picture of the image kind
  int layer = 0;                    // -1 below the cells, 0 and 1 above them; others are not drawn
  bool marked = false;              // goes at the next removal
  bool meets_entities = false;      // takes part actively in contacts with other entities
  float contact_margin = 0;         // added to the boxes in contact tests
  float rotation = 0;               // radians, clockwise on the screen
  float spin = 0;                   // added to the rotation once a step
  bool mirrored = false;            // picture flipped left-right
  int shot_step = -1;               // memory for games
  int spawn_step = -1;              // memory for games
  int life_time = 0;                // steps lived
  int expiry = -1;                  // > 0: marked once life_time > expiry
  bool screen_coordinates = false;  // the box is given as shares of the picture
  float friction = 1;               // factor on the velocity each step
  bool smart = false;               // moves by smart motion and meets cells
  bool avoids_collisions = false;   // ignored by the collision test of placing
  bool auto_remove = true;          // removed when out of the world
  float opacity = 1;
  float health = 1;
  float angle = -100;       // memory for games
  float growth = 1;         // factor on both half-sizes each step
  float fading = 1;         // factor on the opacity each step
  float patrol_center = 0;  // memory for games

  // An entity with the start values of its kind (explosions and trails grow, fade and expire).
  static Entity Make(int kind, float x, float y, float vx, float vy, float rx, float ry);

  // What happens to every entity once a step, after smart motion if it has any: moves (unless
  // smart), turns, slows down, ages, grows and fades.
  void Step();
};

// Whether the boxes overlap, `margin` added to the sum of the half-sizes; touching is not
// overlapping.
inline bool Overlap(const Entity& a, const Entity& b, float margin) {
  return std::fabs(a.x - b.x) < (a.rx + b.rx) + margin &&
         std::fabs(a.y - b.y) < (a.ry + b.ry) + margin;
}

}  // namespace procgen

#endif  // ENVCORE_WORLD_ENTITY_H_
