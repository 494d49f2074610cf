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

// What a thing means to a player.
enum class Role {
  kAgent,
  kKills,     // or costs
  kPays,      // or is the goal
  kBlocks,    // stops the agent
  kHarmless,  // none of these: decoration, the agent's own shots, what may be walked on
  kNamed,     // matters by which one it is: the red key, the lock of the red key
};

// "agent", "kills", ...
absl::string_view RoleName(Role role);

// A few image kinds.
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

// In the place of an image kind: the flat square of CellDots.
inline constexpr int kDotImage = -1;
// In the place of a backdrop's image kind: the game's background pictures.
inline constexpr int kBackgroundBackdrop = -1;

// A thing that plays a part in a game.
struct Part {
  absl::string_view name;
  Role role = Role::kHarmless;
  ImageKinds image_kinds = {};  // all that it shows itself as
  float width = 1;              // of its picture, cells
  float height = 1;
  bool keeps_ratio = false;  // the picture keeps its ratio and fits in the box, else it fills it
  int first_theme = 0;
  int last_theme = std::numeric_limits<int>::max();  // or the last that there is
  ImageKinds backdrops = {kBackgroundBackdrop};      // what it may be seen on
};

// The parts of a game, with their sizes in the mode that shows them smallest.
struct Roles {
  absl::string_view game;
  DistributionMode mode = DistributionMode::kHard;
  absl::Span<const Part> parts;
};

// One for each game, sorted by name.
absl::Span<const Roles> AllRoles();

// That of a game. REQUIRES: the suite has it.
const Roles& RolesOf(absl::string_view game);

// Whether a player must tell one from the other: they play different roles, or matter by which one
// they are. (That each part must be told from the backdrop behind it is not said here.)
bool MustDiffer(const Part& a, const Part& b);

}  // namespace procgen

#endif  // TOOLS_ART_ROLES_H_
