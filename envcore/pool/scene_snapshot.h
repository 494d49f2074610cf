#ifndef ENVCORE_POOL_SCENE_SNAPSHOT_H_
#define ENVCORE_POOL_SCENE_SNAPSHOT_H_

#include <cstdint>
#include <memory>

#include "absl/types/span.h"

namespace procgen {

class Environment;
class GameArt;
class Rasteriser;

// What an environment shows at a moment, to be drawn when it suits: meanwhile the environment moves
// on, and the pool may go. Threads: compatible; moved, never copied.
class SceneSnapshot {
 public:
  // `art`: of the environment's game.
  SceneSnapshot(const Environment& environment, std::shared_ptr<const GameArt> art);
  SceneSnapshot(SceneSnapshot&& other) noexcept;
  SceneSnapshot& operator=(SceneSnapshot&& other) noexcept;
  ~SceneSnapshot();

 private:
  friend class SceneSnapshotRenderer;
  struct Content;

  std::unique_ptr<Content> content_;
};

// Draws scene snapshots, and keeps the memory for that from one to the next.
// Threads: compatible (one thread at a time).
class SceneSnapshotRenderer {
 public:
  SceneSnapshotRenderer();
  ~SceneSnapshotRenderer();
  SceneSnapshotRenderer(const SceneSnapshotRenderer&) = delete;
  SceneSnapshotRenderer& operator=(const SceneSnapshotRenderer&) = delete;

  // As Pool::Render draws it. `frame`: uint8 [size_px, size_px, 3].
  // REQUIRES: size_px in [kHumanViewSizePxMin, kHumanViewSizePxMax].
  void DrawHumanView(const SceneSnapshot& snapshot, int32_t size_px, absl::Span<uint8_t> frame);
  // As an observation in the default format. `frame`: uint8 [64, 64, 3].
  void DrawAgentView(const SceneSnapshot& snapshot, absl::Span<uint8_t> frame);

 private:
  const std::unique_ptr<Rasteriser> rasteriser_;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_SCENE_SNAPSHOT_H_
