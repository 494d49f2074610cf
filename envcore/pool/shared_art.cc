#include "envcore/pool/shared_art.h"

namespace procgen {

std::shared_ptr<const GameArt> SharedArt(const GameFacts& /*game*/, const GameArtFacts& /*art*/) {
  return std::make_shared<GameArt>();
}

}  // namespace procgen
