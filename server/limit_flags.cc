#include "server/limit_flags.h"

#include <algorithm>
#include <cstdint>

#include "absl/flags/flag.h"
#include "absl/strings/str_cat.h"

#define PROCGEN_FLAG(name, value, least, most, what) \
  ABSL_FLAG(int64_t, name, value, absl::StrCat(what, "; ", least, " to ", most));
PROCGEN_LIMITS(PROCGEN_FLAG)
#undef PROCGEN_FLAG

namespace procgen {

Limits ReadLimitFlags() {
  Limits limits;
#define PROCGEN_READ(name, value, least, most, what) limits.name = absl::GetFlag(FLAGS_##name);
  PROCGEN_LIMITS(PROCGEN_READ)
#undef PROCGEN_READ
  limits.owner_env_count_max = std::min(limits.owner_env_count_max, limits.env_count_max);
  return limits;
}

}  // namespace procgen
