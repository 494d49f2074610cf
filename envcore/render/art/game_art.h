#ifndef ENVCORE_RENDER_ART_GAME_ART_H_
#define ENVCORE_RENDER_ART_GAME_ART_H_

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/call_once.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/render/art/art_pack.h"
#include "envcore/render/art/mipmapped_image.h"
#include "envcore/scene/art_slot.h"
#include "envcore/world/kinds.h"

namespace procgen {

// The image of a sprite, and which drawing rules apply.
struct SpriteArt {
  const MipmappedImage* picture = nullptr;
  bool generated = false;  // made from random numbers; other rounding rules
};

// All images of one game, shared by all environments of all pools. An image is decoded, mirrored or
// painted on first use. Returned images live as long as this object. Threads: thread-safe.
class GameArt {
 public:
  // `slots`: the game's own slots. A kind without one shows the shared slot of that kind. If there
  // is none, or the pack has no image for it, the kind shows an image made from random numbers,
  // with seed art_seed + kind. `block_shaped_kinds`: kinds whose generated image fills its canvas.
  GameArt(std::shared_ptr<const ArtPack> pack, absl::string_view game,
          absl::Span<const ArtSlot> slots, uint32_t art_seed,
          absl::Span<const int> block_shaped_kinds);

  // Returns the image of a kind in the pack's art. A theme that the kind does not have shows theme
  // 0.
  // REQUIRES: 0 <= kind < kKindCount.
  SpriteArt SpriteOf(int kind, int theme, bool mirrored) const;
  // Returns the generated image of a kind, the same for all themes. REQUIRES: 0 <= kind <
  // kKindCount.
  SpriteArt GeneratedOf(int kind, bool mirrored) const;
  // Returns a background. Null: the pack does not have it. REQUIRES: `index` is in the group.
  const MipmappedImage* BackgroundOf(BackgroundGroup group, int index) const;

 private:
  // An image and its mirror image.
  struct Facing {
    mutable absl::once_flag once;
    mutable absl::once_flag mirrored_once;
    mutable const MipmappedImage* picture = nullptr;
    mutable MipmappedImage painted;
    mutable MipmappedImage mirrored;
  };
  struct Slot {
    Slot(absl::string_view game, const ArtSlot& art) : game(game), art(art) {}

    std::string game;  // or "shared"
    ArtSlot art;
    Facing facing;
  };
  struct Kind {
    bool block_shaped = false;
    std::vector<std::unique_ptr<Slot>> themes;  // by theme; null: no such theme
    Facing generated;
  };

  void AddSlots(absl::string_view game, absl::Span<const ArtSlot> slots);
  static const MipmappedImage* Oriented(const Facing& facing, bool mirrored);

  std::shared_ptr<const ArtPack> pack_;
  uint32_t art_seed_;
  std::array<Kind, kKindCount> kinds_;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_GAME_ART_H_
