#include "envcore/render/art/game_art.h"

#include <utility>

#include "absl/strings/string_view.h"
#include "envcore/level/generated_art.h"
#include "envcore/random/random_stream.h"
#include "envcore/render/art/generated_painting.h"

namespace procgen {

GameArt::GameArt(std::shared_ptr<const ArtPack> pack, absl::string_view game,
                 absl::Span<const ArtSlot> slots, uint32_t art_seed,
                 absl::Span<const int> block_shaped_kinds)
    : pack_(std::move(pack)), art_seed_(art_seed) {
  for (const int kind : block_shaped_kinds) {
    kinds_[static_cast<size_t>(kind)].block_shaped = true;
  }
  AddSlots(game, slots);
  for (const ArtSlot& slot : SharedArtSlots()) {
    if (kinds_[static_cast<size_t>(slot.kind)].themes.empty()) {
      AddSlots("shared", absl::MakeConstSpan(&slot, 1));
    }
  }
}

void GameArt::AddSlots(absl::string_view game, absl::Span<const ArtSlot> slots) {
  for (const ArtSlot& slot : slots) {
    auto& themes = kinds_[static_cast<size_t>(slot.kind)].themes;
    const auto theme = static_cast<size_t>(slot.theme);
    if (themes.size() <= theme) {
      themes.resize(theme + 1);
    }
    themes[theme] = std::make_unique<Slot>(game, slot);
  }
}

SpriteArt GameArt::SpriteOf(int kind, int theme, bool mirrored) const {
  const auto& themes = kinds_[static_cast<size_t>(kind)].themes;
  if (themes.empty()) {
    return GeneratedOf(kind, mirrored);
  }
  const size_t shown = theme >= 0 && static_cast<size_t>(theme) < themes.size() &&
                               themes[static_cast<size_t>(theme)] != nullptr
                           ? static_cast<size_t>(theme)
                           : 0;
  const Slot* slot = themes[shown].get();
  if (slot == nullptr) {
    return GeneratedOf(kind, mirrored);
  }
  absl::call_once(slot->facing.once,
                  [&] { slot->facing.picture = pack_->Sprite(slot->game, slot->art); });
  if (slot->facing.picture == nullptr) {
    return GeneratedOf(kind, mirrored);
  }
  return {Oriented(slot->facing, mirrored), false};
}

SpriteArt GameArt::GeneratedOf(int kind, bool mirrored) const {
  const Kind& entry = kinds_[static_cast<size_t>(kind)];
  const Facing& facing = entry.generated;
  absl::call_once(facing.once, [&] {
    RandomStream random(static_cast<int64_t>(art_seed_) + kind);
    const GeneratedArt art = entry.block_shaped ? GenerateBlock(random) : GenerateFigure(random);
    facing.painted = MipmappedImage(PaintGenerated(art), Levels::kOne);
    facing.picture = &facing.painted;
  });
  return {Oriented(facing, mirrored), true};
}

const MipmappedImage* GameArt::Oriented(const Facing& facing, bool mirrored) {
  if (!mirrored) {
    return facing.picture;
  }
  absl::call_once(facing.mirrored_once, [&] { facing.mirrored = facing.picture->Mirrored(); });
  return &facing.mirrored;
}

const MipmappedImage* GameArt::BackgroundOf(BackgroundGroup group, int index) const {
  return pack_->Background(BackgroundsOf(group)[static_cast<size_t>(index)]);
}

}  // namespace procgen
