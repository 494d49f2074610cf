#ifndef ENVCORE_SCENE_ART_SLOT_H_
#define ENVCORE_SCENE_ART_SLOT_H_

#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// One picture that a game can show: theme `theme` of image kind `kind`. Facts about the art
// of Procgen 0.10.7 are rules: the number of themes decides draws, and width / height decides
// sizes. They never follow the art pack in use.
struct ArtSlot {
  int kind;
  int theme;
  absl::string_view name;  // of our own picture, without the theme: "fish" is bigfish/fish_<theme>
  absl::string_view upstream_path;  // path of the file in an art folder of upstream's layout
  int width_px;                     // of upstream's picture
  int height_px;
};

// The slots that all games share: explosions and trail.
absl::Span<const ArtSlot> SharedArtSlots();

// A group of backgrounds: the number of its pictures decides a draw.
enum class BackgroundGroup { kPlatform, kSpace, kTopdown, kTopdownSimple, kWater, kWaterSurface };

struct BackgroundSlot {
  absl::string_view name;           // of our own picture: "platform_00"
  absl::string_view upstream_path;  // path of the file in upstream's art
};

// The pictures of a group in the order of their indices.
absl::Span<const BackgroundSlot> BackgroundsOf(BackgroundGroup group);

}  // namespace procgen

#endif  // ENVCORE_SCENE_ART_SLOT_H_
