#ifndef ENVCORE_POOL_SCENE_SNAPSHOT_H_
#define ENVCORE_POOL_SCENE_SNAPSHOT_H_

#include <cstdint>
#include <memory>

#include "absl/types/span.h"

namespace procgen {

class Environment;
class GameArt;
class Rasteriser;

// A copy of what an environment shows, for rendering later. It does not refer to the environment or
// the pool, which may change or be destroyed meanwhile. Threads: compatible. Movable, not copyable.
class SceneSnapshot {
 public:
  // `art`: the art of the environment's game.
  SceneSnapshot(const Environment& environment, std::shared_ptr<const GameArt> art);
  // With the whole level.
  static SceneSnapshot OfLevel(Environment* environment, std::shared_ptr<const GameArt> art);
  SceneSnapshot(SceneSnapshot&& other) noexcept;
  SceneSnapshot& operator=(SceneSnapshot&& other) noexcept;
  ~SceneSnapshot();

 private:
  friend class SceneSnapshotRenderer;
  struct Content;

  explicit SceneSnapshot(std::shared_ptr<const GameArt> art);
  // Copies what the scene points to.
  void CopyReferences();

  std::unique_ptr<Content> content_;
};

// The last scene of an episode of one environment.
struct FinalScene {
  int32_t environment = 0;  // index in the pool
  // Shared, because several readers may render it. Null: no episode ended.
  std::shared_ptr<const SceneSnapshot> scene;
};

// Renders scene snapshots. Keeps its buffers between calls.
// Threads: compatible (one thread at a time).
class SceneSnapshotRenderer {
 public:
  SceneSnapshotRenderer();
  ~SceneSnapshotRenderer();
  SceneSnapshotRenderer(const SceneSnapshotRenderer&) = delete;
  SceneSnapshotRenderer& operator=(const SceneSnapshotRenderer&) = delete;

  // Draws the same image as Pool::Render. `frame`: uint8 [size_px, size_px, 3].
  // REQUIRES: size_px in [kHumanViewSizePxMin, kHumanViewSizePxMax].
  void DrawHumanView(const SceneSnapshot& snapshot, int32_t size_px, absl::Span<uint8_t> frame);
  // Draws an observation in the default format. `frame`: uint8 [64, 64, 3].
  void DrawAgentView(const SceneSnapshot& snapshot, absl::Span<uint8_t> frame);

 private:
  const std::unique_ptr<Rasteriser> rasteriser_;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_SCENE_SNAPSHOT_H_
