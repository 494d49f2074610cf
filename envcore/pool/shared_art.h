#ifndef ENVCORE_POOL_SHARED_ART_H_
#define ENVCORE_POOL_SHARED_ART_H_

#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

class ArtPack;
class GameArt;
struct GameArtSpec;
struct GameSpec;

// The art that pools draw with: a set of pictures, and what each game shows of it. It decides
// pixels and nothing else: levels, rewards and ends are the same with any art. Pools that are given
// the same SharedArt share what is decoded; it is freed with the last of its owners.
// Threads: any method from any thread.
class SharedArt {
 public:
  // The art that is built in. Lives as long as the process.
  static std::shared_ptr<const SharedArt> Embedded();

  // Art from a folder in the layout of Procgen 0.10.7, with or without a slash at the end: with
  // upstream's pictures in it, the agent's view is upstream's to the last byte. All of its files
  // are read and checked now, so that a lack is told at the start and the folder is not needed
  // afterwards; pictures are decoded when first shown. Errors: NOT_FOUND the folder or a file;
  // INVALID_ARGUMENT a file that cannot be read, is no sound PNG, or has not the size that the
  // games' sizes follow from. The message names the first few files and how many there are.
  static absl::StatusOr<std::shared_ptr<const SharedArt>> LoadFolder(const std::string& folder);

  explicit SharedArt(std::shared_ptr<const ArtPack> pack);
  ~SharedArt();
  SharedArt(const SharedArt&) = delete;
  SharedArt& operator=(const SharedArt&) = delete;

  // What a game shows, resolved when it is first asked for. `spec`: the game's own art spec.
  std::shared_ptr<const GameArt> Of(const GameSpec& game, const GameArtSpec& spec) const;

 private:
  const std::shared_ptr<const ArtPack> pack_;
  // What is in it never changes, so filling it when asked is no state.
  mutable absl::Mutex mutex_;
  mutable std::map<std::string, std::shared_ptr<const GameArt>> arts_
      ABSL_GUARDED_BY(mutex_);  // by game
};

}  // namespace procgen

#endif  // ENVCORE_POOL_SHARED_ART_H_
