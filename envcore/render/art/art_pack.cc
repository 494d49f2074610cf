#include "envcore/render/art/art_pack.h"

#include <utility>

#include "absl/base/call_once.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "envcore/art/embedded_art.h"
#include "envcore/render/art/png_decoding.h"
#include "envcore/status/status.h"

namespace procgen {
namespace {

// An image that is decoded on first use.
struct LazyImage {
  mutable absl::once_flag once;
  mutable MipmappedImage picture;  // empty: not a valid PNG

  const MipmappedImage* Get(absl::string_view png, AlphaUse alpha_use, Levels levels) const {
    absl::call_once(once, [&] {
      StatusOr<Image> image = DecodePng(png, alpha_use);
      if (image.ok()) {
        picture = MipmappedImage(*std::move(image), levels);
      }
    });
    return picture.empty() ? nullptr : &picture;
  }
};

Levels LevelsOf(ArtLayout layout) {
  return layout == ArtLayout::kOwn ? Levels::kAll : Levels::kOne;
}

// 64-bit FNV-1a.
class Hash {
 public:
  void Add(absl::string_view bytes) {
    for (const char byte : bytes) {
      value_ = (value_ ^ static_cast<uint8_t>(byte)) * 1099511628211U;
    }
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 14695981039346656037U;
};

uint64_t HashOf(ArtLayout layout, const std::vector<ArtFile>& files) {
  Hash hash;
  hash.Add(layout == ArtLayout::kOwn ? "own" : "upstream");
  for (const ArtFile& file : files) {
    hash.Add(absl::StrCat(file.name, " ", file.png.size(), "\n"));
    hash.Add(file.png);
  }
  return hash.value();
}

std::string OwnName(absl::string_view game, const ArtSlot& slot) {
  return absl::StrCat(game, "/", slot.name, "_", slot.theme);
}

}  // namespace

struct ArtPack::Entry {
  explicit Entry(absl::string_view png) : png(png) {}

  absl::string_view png;
  LazyImage sprite;
  LazyImage background;
};

ArtPack::ArtPack(ArtLayout layout, const std::vector<ArtFile>& files,
                 std::shared_ptr<const void> bytes)
    : layout_(layout), fingerprint_(HashOf(layout, files)), bytes_(std::move(bytes)) {
  for (const ArtFile& file : files) {
    entries_.emplace(file.name, std::make_unique<Entry>(file.png));
  }
}

ArtPack::~ArtPack() = default;

std::shared_ptr<const ArtPack> ArtPack::Embedded() {
  // Never destroyed, because pools may outlive static objects.
  static const auto* const pack = new std::shared_ptr<const ArtPack>([] {
    std::vector<ArtFile> files;
    for (const EmbeddedFile& file : EmbeddedArt()) {
      files.push_back({std::string(file.name), file.png});
    }
    return std::make_shared<const ArtPack>(ArtLayout::kOwn, files);
  }());
  return *pack;
}

const MipmappedImage* ArtPack::Sprite(absl::string_view game, const ArtSlot& slot) const {
  const Entry* entry =
      Find(layout_ == ArtLayout::kOwn ? OwnName(game, slot) : std::string(slot.upstream_path));
  return entry == nullptr
             ? nullptr
             : entry->sprite.Get(entry->png, AlphaUse::kPremultiplied, LevelsOf(layout_));
}

const MipmappedImage* ArtPack::Background(const BackgroundSlot& slot) const {
  const Entry* entry =
      Find(std::string(layout_ == ArtLayout::kOwn ? slot.name : slot.upstream_path));
  return entry == nullptr
             ? nullptr
             : entry->background.Get(entry->png, AlphaUse::kIgnored, LevelsOf(layout_));
}

const ArtPack::Entry* ArtPack::Find(const std::string& name) const {
  const auto it = entries_.find(name);
  return it == entries_.end() ? nullptr : it->second.get();
}

}  // namespace procgen
