#ifndef ENVCORE_POOL_SHARED_ART_H_
#define ENVCORE_POOL_SHARED_ART_H_

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "envcore/status/status.h"

namespace procgen {

class ArtPack;
class GameArt;
struct GameArtSpec;
struct GameSpec;

// The art that pools draw with: an art pack, and what each game shows of it. It changes pixels
// only; levels, rewards and episode ends are the same with any art. Pools with the same SharedArt
// share its decoded images. It is freed with its last owner.
// Threads: thread-safe.
class SharedArt {
 public:
  // The built-in art. Lives as long as the process.
  static std::shared_ptr<const SharedArt> Embedded();

  // Loads art from a folder in the layout of Procgen 0.10.7 (upstream); a trailing slash is
  // allowed. With upstream's images the agent's view equals upstream's byte for byte. All files are
  // read and checked now, so the folder is not needed afterwards; each image is decoded when it is
  // first drawn.
  // Errors: NOT_FOUND: the folder or a file does not exist. INVALID_ARGUMENT: a file cannot be
  // read, is not a valid PNG, or does not have the size that entity sizes follow from. The message
  // names the first few files and the number of files with errors.
  static StatusOr<std::shared_ptr<const SharedArt>> LoadFolder(const std::string& folder);

  explicit SharedArt(std::shared_ptr<const ArtPack> pack);
  ~SharedArt();
  SharedArt(const SharedArt&) = delete;
  SharedArt& operator=(const SharedArt&) = delete;

  // As ArtPack::fingerprint.
  uint64_t fingerprint() const;

  // The art of one game, resolved on first use. `spec`: the game's art spec.
  std::shared_ptr<const GameArt> Of(const GameSpec& game, const GameArtSpec& spec) const;

 private:
  const std::shared_ptr<const ArtPack> pack_;
  // A cache: an entry never changes once it is there, hence mutable.
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::shared_ptr<const GameArt>> arts_;  // by game; under mutex_
};

}  // namespace procgen

#endif  // ENVCORE_POOL_SHARED_ART_H_
