#include "envcore/pool/shared_art.h"

#include <utility>

#include "envcore/games/game_catalog.h"
#include "envcore/pool/upstream_images.h"
#include "envcore/render/art/art_dir.h"
#include "envcore/render/art/art_pack.h"
#include "envcore/render/art/game_art.h"

namespace procgen {

std::shared_ptr<const SharedArt> SharedArt::Embedded() {
  // Never destroyed, because pools may outlive static objects.
  static const auto* const art =
      new std::shared_ptr<const SharedArt>(std::make_shared<const SharedArt>(ArtPack::Embedded()));
  return *art;
}

StatusOr<std::shared_ptr<const SharedArt>> SharedArt::LoadFolder(const std::string& folder) {
  auto pack = ReadArtDir(folder, UpstreamImages());
  if (!pack.ok()) {
    return pack.status();
  }
  return std::make_shared<const SharedArt>(*std::move(pack));
}

SharedArt::SharedArt(std::shared_ptr<const ArtPack> pack) : pack_(std::move(pack)) {}

SharedArt::~SharedArt() = default;

uint64_t SharedArt::fingerprint() const { return pack_->fingerprint(); }

std::shared_ptr<const GameArt> SharedArt::Of(const GameSpec& game, const GameArtSpec& spec) const {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<const GameArt>& found = arts_[std::string(game.name)];
  if (found == nullptr) {
    found = std::make_shared<GameArt>(pack_, game.name, spec.slots, game.ArtSeed(),
                                      spec.block_shaped_kinds);
  }
  return found;
}

}  // namespace procgen
