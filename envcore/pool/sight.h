#ifndef ENVCORE_POOL_SIGHT_H_
#define ENVCORE_POOL_SIGHT_H_

#include <cstdint>
#include <memory>

#include "absl/types/span.h"

namespace procgen {

class Environment;
class GameArt;
class Rasteriser;

// What an environment shows at a moment, to be drawn when it suits: meanwhile the environment moves
// on, and the pool may go. Threads: compatible; moved, never copied.
class Sight {
 public:
  // `art`: of the environment's game.
  Sight(const Environment& environment, std::shared_ptr<const GameArt> art);
  Sight(Sight&& other) noexcept;
  Sight& operator=(Sight&& other) noexcept;
  ~Sight();

 private:
  friend class SightPainter;
  struct Content;

  std::unique_ptr<Content> content_;
};

// Draws sights, and keeps the memory for that from one to the next.
// Threads: compatible (one thread at a time).
class SightPainter {
 public:
  SightPainter();
  ~SightPainter();
  SightPainter(const SightPainter&) = delete;
  SightPainter& operator=(const SightPainter&) = delete;

  // As Pool::Render draws it. `frame`: uint8 [side_px, side_px, 3].
  // REQUIRES: side_px in [kHumanViewSidePxMin, kHumanViewSidePxMax].
  void DrawHumanView(const Sight& sight, int32_t side_px, absl::Span<uint8_t> frame);
  // As an observation in the default format. `frame`: uint8 [64, 64, 3].
  void DrawAgentView(const Sight& sight, absl::Span<uint8_t> frame);

 private:
  const std::unique_ptr<Rasteriser> rasteriser_;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_SIGHT_H_
