#include "envcore/scene/art_slot.h"

namespace procgen {
namespace {

constexpr ArtSlot kSharedArtSlots[] = {
    {54, 0, "explosion_a", "misc_assets/explosion1.png", 60, 60},
    {55, 0, "explosion_b", "misc_assets/explosion2.png", 57, 56},
    {56, 0, "explosion_c", "misc_assets/explosion3.png", 64, 63},
    {57, 0, "explosion_d", "misc_assets/explosion4.png", 46, 45},
    {58, 0, "explosion_e", "misc_assets/explosion5.png", 53, 52},
    {59, 0, "trail", "misc_assets/iconCircle_white.png", 17, 17},
};

// The platform group has its own backgrounds, followed by those of the space group.
constexpr BackgroundSlot kPlatform[] = {
    {"platform_00", "platform_backgrounds/alien_bg.png"},
    {"platform_01", "platform_backgrounds/another_world_bg.png"},
    {"platform_02", "platform_backgrounds/back_cave.png"},
    {"platform_03", "platform_backgrounds/caverns.png"},
    {"platform_04", "platform_backgrounds/cyberpunk_bg.png"},
    {"platform_05", "platform_backgrounds/parallax_forest.png"},
    {"platform_06", "platform_backgrounds/scifi_bg.png"},
    {"platform_07", "platform_backgrounds/scifi2_bg.png"},
    {"platform_08", "platform_backgrounds/living_tissue_bg.png"},
    {"platform_09", "platform_backgrounds/airadventurelevel1.png"},
    {"platform_10", "platform_backgrounds/airadventurelevel2.png"},
    {"platform_11", "platform_backgrounds/airadventurelevel3.png"},
    {"platform_12", "platform_backgrounds/airadventurelevel4.png"},
    {"platform_13", "platform_backgrounds/cave_background.png"},
    {"platform_14", "platform_backgrounds/blue_desert.png"},
    {"platform_15", "platform_backgrounds/blue_grass.png"},
    {"platform_16", "platform_backgrounds/blue_land.png"},
    {"platform_17", "platform_backgrounds/blue_shroom.png"},
    {"platform_18", "platform_backgrounds/colored_desert.png"},
    {"platform_19", "platform_backgrounds/colored_grass.png"},
    {"platform_20", "platform_backgrounds/colored_land.png"},
    {"platform_21", "platform_backgrounds/colored_shroom.png"},
    {"platform_22", "platform_backgrounds/landscape1.png"},
    {"platform_23", "platform_backgrounds/landscape2.png"},
    {"platform_24", "platform_backgrounds/landscape3.png"},
    {"platform_25", "platform_backgrounds/landscape4.png"},
    {"platform_26", "platform_backgrounds/battleback1.png"},
    {"platform_27", "platform_backgrounds/battleback2.png"},
    {"platform_28", "platform_backgrounds/battleback3.png"},
    {"platform_29", "platform_backgrounds/battleback4.png"},
    {"platform_30", "platform_backgrounds/battleback5.png"},
    {"platform_31", "platform_backgrounds/battleback6.png"},
    {"platform_32", "platform_backgrounds/battleback7.png"},
    {"platform_33", "platform_backgrounds/battleback8.png"},
    {"platform_34", "platform_backgrounds/battleback9.png"},
    {"platform_35", "platform_backgrounds/battleback10.png"},
    {"platform_36", "platform_backgrounds/sunrise.png"},
    {"platform_37", "platform_backgrounds_2/beach1.png"},
    {"platform_38", "platform_backgrounds_2/beach2.png"},
    {"platform_39", "platform_backgrounds_2/beach3.png"},
    {"platform_40", "platform_backgrounds_2/beach4.png"},
    {"platform_41", "platform_backgrounds_2/fantasy1.png"},
    {"platform_42", "platform_backgrounds_2/fantasy2.png"},
    {"platform_43", "platform_backgrounds_2/fantasy3.png"},
    {"platform_44", "platform_backgrounds_2/fantasy4.png"},
    {"platform_45", "platform_backgrounds_2/candy1.png"},
    {"platform_46", "platform_backgrounds_2/candy2.png"},
    {"platform_47", "platform_backgrounds_2/candy3.png"},
    {"platform_48", "platform_backgrounds_2/candy4.png"},
    {"space_00", "space_backgrounds/deep_space_01.png"},
    {"space_01", "space_backgrounds/spacegen_01.png"},
    {"space_02", "space_backgrounds/milky_way_01.png"},
    {"space_03", "space_backgrounds/ez_space_lite_01.png"},
    {"space_04", "space_backgrounds/meyespace_v1_01.png"},
    {"space_05", "space_backgrounds/eye_nebula_01.png"},
    {"space_06", "space_backgrounds/deep_sky_01.png"},
    {"space_07", "space_backgrounds/space_nebula_01.png"},
    {"space_08", "space_backgrounds/Background-1.png"},
    {"space_09", "space_backgrounds/Background-2.png"},
    {"space_10", "space_backgrounds/Background-3.png"},
    {"space_11", "space_backgrounds/Background-4.png"},
    {"space_12", "space_backgrounds/parallax-space-backgound.png"},
};

constexpr BackgroundSlot kTopdown[] = {
    {"topdown_00", "topdown_backgrounds/floortiles.png"},
    {"topdown_01", "topdown_backgrounds/backgrounddetailed1.png"},
    {"topdown_02", "topdown_backgrounds/backgrounddetailed2.png"},
    {"topdown_03", "topdown_backgrounds/backgrounddetailed3.png"},
    {"topdown_04", "topdown_backgrounds/backgrounddetailed4.png"},
    {"topdown_05", "topdown_backgrounds/backgrounddetailed5.png"},
    {"topdown_06", "topdown_backgrounds/backgrounddetailed6.png"},
    {"topdown_07", "topdown_backgrounds/backgrounddetailed7.png"},
    {"topdown_08", "topdown_backgrounds/backgrounddetailed8.png"},
};

constexpr BackgroundSlot kWater[] = {
    {"water_00", "water_backgrounds/water1.png"},
    {"water_01", "water_backgrounds/water2.png"},
    {"water_02", "water_backgrounds/water3.png"},
    {"water_03", "water_backgrounds/water4.png"},
    {"water_04", "water_backgrounds/underwater1.png"},
    {"water_05", "water_backgrounds/underwater2.png"},
    {"water_06", "water_backgrounds/underwater3.png"},
};

constexpr size_t kOwnPlatformCount = 49;
constexpr size_t kTopdownSimpleCount = 1;  // the first of the topdown group
constexpr size_t kWaterSurfaceCount = 4;   // the first of the water group

}  // namespace

absl::Span<const ArtSlot> SharedArtSlots() { return kSharedArtSlots; }

absl::Span<const BackgroundSlot> BackgroundsOf(BackgroundGroup group) {
  switch (group) {
    case BackgroundGroup::kPlatform:
      return kPlatform;
    case BackgroundGroup::kSpace:
      return absl::MakeConstSpan(kPlatform).subspan(kOwnPlatformCount);
    case BackgroundGroup::kTopdown:
      return kTopdown;
    case BackgroundGroup::kTopdownSimple:
      return absl::MakeConstSpan(kTopdown).first(kTopdownSimpleCount);
    case BackgroundGroup::kWater:
      return kWater;
    case BackgroundGroup::kWaterSurface:
      return absl::MakeConstSpan(kWater).first(kWaterSurfaceCount);
  }
  return {};
}

}  // namespace procgen
