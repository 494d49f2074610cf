#ifndef ENVCORE_WORLD_KINDS_H_
#define ENVCORE_WORLD_KINDS_H_

namespace procgen {

// Kinds of cells and entities, one number space. The numbers select art and flat colors, so they
// must never change. These are shared by all games; each game's file defines its own.
inline constexpr int kAgentKind = 0;
inline constexpr int kWallKind = 51;
inline constexpr int kExitKind = 52;
inline constexpr int kExplosionKind = 54;  // first of five images, 54 to 58
inline constexpr int kLastExplosionKind = 58;
inline constexpr int kTrailKind = 59;
// Explosions and trails neither block nor reflect.
inline constexpr bool IsEffect(int kind) { return kind >= kExplosionKind && kind <= kTrailKind; }
inline constexpr int kEmptyKind = 100;
inline constexpr int kOutsideKind = -1;  // outside the world, unless a game sets another kind
// Kinds that can be drawn are below this number.
inline constexpr int kKindCount = 100;

}  // namespace procgen

#endif  // ENVCORE_WORLD_KINDS_H_
