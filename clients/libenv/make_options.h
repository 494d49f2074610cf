#ifndef CLIENTS_LIBENV_MAKE_OPTIONS_H_
#define CLIENTS_LIBENV_MAKE_OPTIONS_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "clients/libenv/libenv.h"
#include "envcore/pool/pool.h"

namespace procgen {

// Maximum number of environments and of threads of one handle.
inline constexpr int32_t kLibenvEnvCountMax = 65536;
inline constexpr int32_t kLibenvThreadCountMax = 1024;

// Options of libenv_make, with the defaults of the interface. They differ from those of the Python
// packages: easy levels, a fixed camera.
struct MakeOptions {
  PoolOptions pool;
  int32_t num_actions = 0;    // reported size of the action space, in [1, kActionCount]
  int32_t num_threads = 4;    // 0: the calling thread steps
  bool render_human = false;  // true: the infos include the human view
  std::string resource_root;  // folder of Procgen 0.10.7's art; empty: built-in art
};

// Reads the options of libenv_make. Errors: INVALID_ARGUMENT an option that is unknown, given
// twice, of another type, out of range or missing; the message names it and what is allowed. Games
// and their modes are validated when the environments are created.
absl::StatusOr<MakeOptions> ReadOptions(int env_count, const LibenvOptions& options);

}  // namespace procgen

#endif  // CLIENTS_LIBENV_MAKE_OPTIONS_H_
