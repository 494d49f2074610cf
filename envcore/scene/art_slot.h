#ifndef ENVCORE_SCENE_ART_SLOT_H_
#define ENVCORE_SCENE_ART_SLOT_H_

#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// One image that a game can show: theme `theme` of image kind `kind`. The facts about the art of
// Procgen 0.10.7 (upstream) are rules: the number of themes decides draws, and width / height
// decides sizes. They do not depend on the art pack in use.
struct ArtSlot {
  int kind;
  int theme;
  absl::string_view name;  // of our image, without the theme: "fish" is bigfish/fish_<theme>
  absl::string_view upstream_path;  // path of the file in upstream's art folder
  int width_px;                     // of upstream's image
  int height_px;
};

// The slots that all games share: explosions and trail.
absl::Span<const ArtSlot> SharedArtSlots();

// A group of backgrounds. The number of its images decides a draw.
enum class BackgroundGroup { kPlatform, kSpace, kTopdown, kTopdownSimple, kWater, kWaterSurface };

struct BackgroundSlot {
  absl::string_view name;           // of our image: "platform_00"
  absl::string_view upstream_path;  // path of the file in upstream's art folder
};

// The backgrounds of a group, in order of index.
absl::Span<const BackgroundSlot> BackgroundsOf(BackgroundGroup group);

}  // namespace procgen

#endif  // ENVCORE_SCENE_ART_SLOT_H_
