#ifndef ENVCORE_RENDER_ART_ART_PACK_H_
#define ENVCORE_RENDER_ART_ART_PACK_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/string_view.h"
#include "envcore/render/art/mipmapped_image.h"
#include "envcore/scene/art_slot.h"

namespace procgen {

// A PNG file of a pack.
struct ArtFile {
  std::string name;       // "coinrun/coin_0" or, in upstream's, "misc_assets/coin.png"
  absl::string_view png;  // its bytes
};

// How the files of a pack are named.
enum class ArtLayout {
  kOwn,       // by game, slot and theme; pictures are also kept reduced (Levels::kAll)
  kUpstream,  // by the paths of Procgen 0.10.7; pictures are drawn exactly as upstream does
};

// A set of pictures, found by what shows them. A file is decoded when it is first asked for.
// Threads: any method from any thread. Source: README.md, "Art packs".
class ArtPack {
 public:
  // `bytes` keeps the memory alive that the files' bytes lie in; null: it stays for ever.
  ArtPack(ArtLayout layout, const std::vector<ArtFile>& files,
          std::shared_ptr<const void> bytes = nullptr);
  ~ArtPack();
  ArtPack(const ArtPack&) = delete;
  ArtPack& operator=(const ArtPack&) = delete;

  // The pack that is built in. Shared: all games' art refers to one pack.
  static std::shared_ptr<const ArtPack> Embedded();

  ArtLayout layout() const { return layout_; }

  // The picture of a slot of `game` ("shared" for the slots that all games share), or of a
  // background. Null: the pack has no such file, or it is no sound PNG. It lives as long as the
  // pack.
  const MipmappedImage* Sprite(absl::string_view game, const ArtSlot& slot) const;
  const MipmappedImage* Background(const BackgroundSlot& slot) const;

 private:
  struct Entry;

  const Entry* Find(const std::string& name) const;

  ArtLayout layout_;
  std::shared_ptr<const void> bytes_;
  absl::flat_hash_map<std::string, std::unique_ptr<Entry>> entries_;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_ART_PACK_H_
