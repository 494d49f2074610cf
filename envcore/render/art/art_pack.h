#ifndef ENVCORE_RENDER_ART_ART_PACK_H_
#define ENVCORE_RENDER_ART_ART_PACK_H_

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/strings/string_view.h"
#include "envcore/render/art/mipmapped_image.h"
#include "envcore/scene/art_slot.h"

namespace procgen {

// A PNG file of a pack.
struct ArtFile {
  std::string name;       // "coinrun/coin_0"; in upstream's layout "misc_assets/coin.png"
  absl::string_view png;  // content
};

// How the files of a pack are named, and how its images are drawn.
enum class ArtLayout {
  kOwn,       // by game, slot and theme; with all mipmap levels (Levels::kAll)
  kUpstream,  // by the paths of Procgen 0.10.7; drawn exactly as upstream draws them
};

// A set of images. A file is decoded on first use.
// Threads: thread-safe. Source: README.md, "Art packs".
class ArtPack {
 public:
  // `bytes` owns the memory of the files' content; null: that memory lives as long as the process.
  ArtPack(ArtLayout layout, const std::vector<ArtFile>& files,
          std::shared_ptr<const void> bytes = nullptr);
  ~ArtPack();
  ArtPack(const ArtPack&) = delete;
  ArtPack& operator=(const ArtPack&) = delete;

  // The built-in pack. The art of all games shares it.
  static std::shared_ptr<const ArtPack> Embedded();

  ArtLayout layout() const { return layout_; }
  // Hash of the names and contents of the files: packs with equal hashes draw equal images.
  uint64_t fingerprint() const { return fingerprint_; }

  // Returns the image of a slot of `game` ("shared" for the slots that all games share), or of a
  // background. Null: the pack has no such file, or the file is not a valid PNG. The image lives as
  // long as the pack.
  const MipmappedImage* Sprite(absl::string_view game, const ArtSlot& slot) const;
  const MipmappedImage* Background(const BackgroundSlot& slot) const;

 private:
  struct Entry;

  const Entry* Find(const std::string& name) const;

  ArtLayout layout_;
  uint64_t fingerprint_;
  std::shared_ptr<const void> bytes_;
  std::unordered_map<std::string, std::unique_ptr<Entry>> entries_;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_ART_PACK_H_
