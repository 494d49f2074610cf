#ifndef ENVCORE_WORLD_KINDS_H_
#define ENVCORE_WORLD_KINDS_H_

namespace procgen {

// Kinds of cells and entities share one space of small integers. The numbers are part of the
// behaviour (they select art, and flat colours are computed from them): never renumber. Each game's
// file lists its own; these belong to all games.
inline constexpr int kAgentKind = 0;
inline constexpr int kWallKind = 51;
inline constexpr int kExitKind = 52;
inline constexpr int kExplosionKind = 54;  // the first of five pictures, 54 to 58
inline constexpr int kLastExplosionKind = 58;
inline constexpr int kTrailKind = 59;
inline constexpr int kEmptyKind = 100;
inline constexpr int kOutsideKind =
    -1;  // what lies outside of the world unless a game says otherwise
// Kinds that can be drawn are below this number.
inline constexpr int kKindCount = 100;

}  // namespace procgen

#endif  // ENVCORE_WORLD_KINDS_H_
