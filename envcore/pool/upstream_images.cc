#include "envcore/pool/upstream_images.h"

#include <map>
#include <memory>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/games/game_catalog.h"
#include "envcore/scene/art_slot.h"

namespace procgen {
namespace {

using PicturesByPath = std::map<absl::string_view, RequiredImage>;

void AddSlots(absl::Span<const ArtSlot> slots, PicturesByPath* pictures) {
  for (const ArtSlot& slot : slots) {
    (*pictures)[slot.upstream_path] = {slot.upstream_path, slot.width_px, slot.height_px};
  }
}

void AddBackgrounds(BackgroundGroup group, PicturesByPath* pictures) {
  for (const BackgroundSlot& slot : BackgroundsOf(group)) {
    pictures->try_emplace(slot.upstream_path, RequiredImage{slot.upstream_path});
  }
}

}  // namespace

std::vector<RequiredImage> UpstreamImages() {
  PicturesByPath pictures;
  AddSlots(SharedArtSlots(), &pictures);
  for (const GameSpec& spec : GameCatalog()) {
    const std::unique_ptr<Game> game = spec.make(GameOptions());
    AddSlots(game->art().slots, &pictures);
    AddBackgrounds(game->art().background_group, &pictures);
  }
  std::vector<RequiredImage> sorted;
  for (const auto& [path, picture] : pictures) {
    sorted.push_back(picture);
  }
  return sorted;
}

}  // namespace procgen
