#include "envcore/pool/shared_art.h"

#include <map>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {
namespace {

// The art of the games that were asked for. What is in it never changes, so sharing it is no state.
class Shelf {
 public:
  std::shared_ptr<const GameArt> Find(const GameFacts& game, const GameArtFacts& art) {
    absl::MutexLock lock(&mutex_);
    std::shared_ptr<const GameArt>& found = arts_[std::string(game.name)];
    if (found == nullptr) {
      found = std::make_shared<GameArt>(ArtPack::Embedded(), game.name, art.slots, game.ArtSeed(),
                                        art.block_shaped_kinds);
    }
    return found;
  }

 private:
  absl::Mutex mutex_;
  std::map<std::string, std::shared_ptr<const GameArt>> arts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

std::shared_ptr<const GameArt> SharedArt(const GameFacts& game, const GameArtFacts& art) {
  static Shelf shelf;
  return shelf.Find(game, art);
}

}  // namespace procgen
