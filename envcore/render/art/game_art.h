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

// A sprite's picture and by which rules it is drawn.
struct SpriteArt {
  const MipmappedImage* picture = nullptr;
  bool generated = false;  // made from random numbers
};

// Everything that one game can show, resolved once and shared by all environments of all pools.
// Pictures are decoded, mirrored or painted when they are first asked for; what is returned lives
// as long as this. Threads: any method from any thread.
class GameArt {
 public:
  // `slots`: the game's own; a kind without one shows the shared slot of that kind or, if there is
  // none or the pack lacks the picture, one made from random numbers, of seed art_seed + kind.
  // `block_shaped_kinds`: those whose generated picture fills its canvas.
  GameArt(std::shared_ptr<const ArtPack> pack, absl::string_view game,
          absl::Span<const ArtSlot> slots, uint32_t art_seed,
          absl::Span<const int> block_shaped_kinds);

  // What an image kind shows with art of the pack. A theme that the kind lacks shows theme 0.
  // REQUIRES: 0 <= kind < kKindCount.
  SpriteArt SpriteOf(int kind, int theme, bool mirrored) const;
  // What it shows with generated art, the same for all themes. REQUIRES: 0 <= kind < kKindCount.
  SpriteArt GeneratedOf(int kind, bool mirrored) const;
  // Null: the pack lacks it. REQUIRES: `index` lies in the group.
  const MipmappedImage* BackgroundOf(BackgroundGroup group, int index) const;

 private:
  // A picture as it is and mirrored.
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
    std::vector<std::unique_ptr<Slot>> themes;  // by theme; null: there is no such theme
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
