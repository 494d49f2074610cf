#ifndef TOOLS_ART_GALLERY_H_
#define TOOLS_ART_GALLERY_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/shared_art.h"
#include "envcore/render/art/game_art.h"
#include "envcore/render/raster/image.h"
#include "envcore/render/scene/rasteriser.h"
#include "envcore/scene/art_slot.h"
#include "nlohmann/json.hpp"

namespace procgen {

// Writes the images of the contact sheets and the list of sheets (README.md, "procgen-gallery").
// Errors of its methods: INVALID_ARGUMENT: an image cannot be written.
// Threads: compatible (one thread at a time).
class Gallery {
 public:
  // Images are written to the folder `pictures` in `folder`, which must exist. `art` must outlive
  // the gallery.
  Gallery(std::string folder, const SharedArt& art);

  // Adds the sheet of a game's levels, its row of the overview, and the sheet of its sprites.
  absl::Status AddGame(const GameSpec& spec);
  // Adds the sheet of the sprites that all games share, drawn with the art of `spec`.
  absl::Status AddSharedSprites(const GameSpec& spec);

  // All sheets as JSON, the input of deploy/mosaic.py.
  std::string SheetList() const;

 private:
  using Json = nlohmann::json;

  absl::Status AddLevel(const GameSpec& spec, DistributionMode mode, int32_t level,
                        Json* agent_views, Json* human_views);
  // Adds the sheet NAME_sprites.png.
  absl::Status AddSprites(const std::string& name, absl::Span<const ArtSlot> slots,
                          const GameArt& art);
  // Writes an image and appends its entry to a sheet.
  absl::Status Write(const Image& image, const std::string& name, const std::string& caption,
                     Json* entries);

  const std::string folder_;
  const SharedArt& art_;
  Rasteriser rasteriser_;
  Json sheets_;
  Json overview_;  // rows
};

}  // namespace procgen

#endif  // TOOLS_ART_GALLERY_H_
