#ifndef TOOLS_ART_ROLES_H_
#define TOOLS_ART_ROLES_H_

#include <array>
#include <cstddef>
#include <initializer_list>
#include <limits>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/games/game_options.h"

namespace procgen {

// The meaning of an object to a player.
enum class Role {
  kAgent,
  kKills,     // or costs
  kPays,      // or is the goal
  kBlocks,    // stops the agent
  kHarmless,  // none of these: decoration, the agent's own shots, walkable ground
  kNamed,     // its identity matters: the red key, the lock of the red key
};

// "agent", "kills", ...
absl::string_view RoleName(Role role);

// A short list of image kinds.
class ImageKinds {
 public:
  static constexpr size_t kCountMax = 5;

  // REQUIRES: at most kCountMax.
  constexpr ImageKinds(std::initializer_list<int> kinds) {  // NOLINT: a list, as in the table
    for (const int kind : kinds) {
      kinds_[count_++] = kind;
    }
  }
  constexpr const int* begin() const { return kinds_.data(); }  // NOLINT: named as the loop wants
  constexpr const int* end() const { return kinds_.data() + count_; }  // NOLINT

 private:
  std::array<int, kCountMax> kinds_ = {};
  size_t count_ = 0;
};

// Instead of an image kind: the flat square of CellDots.
inline constexpr int kDotImage = -1;
// Instead of a backdrop's image kind: the game's background images.
inline constexpr int kBackgroundBackdrop = -1;

// An object with a role in a game.
struct Part {
  absl::string_view name;
  Role role = Role::kHarmless;
  ImageKinds image_kinds = {};  // all image kinds it is shown with
  float width = 1;              // of its image, cells
  float height = 1;
  bool keeps_ratio = false;  // the image fits into the box with its ratio, else it fills the box
  int first_theme = 0;
  int last_theme = std::numeric_limits<int>::max();  // clipped to the number of themes
  ImageKinds backdrops = {kBackgroundBackdrop};      // what it may be seen on
};

// The parts of a game, with their sizes in the mode that shows them smallest.
struct Roles {
  absl::string_view game;
  DistributionMode mode = DistributionMode::kHard;
  absl::Span<const Part> parts;
};

// The roles of all games, sorted by game.
absl::Span<const Roles> AllRoles();

// The roles of one game. REQUIRES: the catalog has the game.
const Roles& RolesOf(absl::string_view game);

// Whether a player must be able to distinguish two parts: they have different roles, or both are
// kNamed. Backdrops are handled elsewhere.
bool MustDiffer(const Part& a, const Part& b);

}  // namespace procgen

#endif  // TOOLS_ART_ROLES_H_
