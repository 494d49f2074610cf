#ifndef CLIENTS_LIBENV_MAKE_OPTIONS_H_
#define CLIENTS_LIBENV_MAKE_OPTIONS_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "clients/libenv/libenv.h"
#include "envcore/pool/pool.h"

namespace procgen {

// The most environments of one handle, and the most threads that step them.
inline constexpr int32_t kLibenvEnvCountMax = 65536;
inline constexpr int32_t kLibenvThreadCountMax = 1024;

// What libenv_make is asked for, with the defaults of the interface (not those of the Python
// package: easy levels, a camera that stands still).
struct MakeOptions {
  PoolOptions pool;
  int32_t num_actions = 0;    // size of the action space that is told, [1, kActionCount]
  int32_t num_threads = 4;    // 0: the calling thread steps
  bool render_human = false;  // the infos have the human view as well
  std::string resource_root;  // folder of Procgen 0.10.7's art; empty: none was named
};

// Reads the options of libenv_make. Errors: INVALID_ARGUMENT an option that is unknown, given
// twice, of another type, out of range or missing (the message names it and says what is allowed).
// Whether the games and their modes exist is left to whoever makes the environments.
absl::StatusOr<MakeOptions> ReadOptions(int env_count, const LibenvOptions& options);

}  // namespace procgen

#endif  // CLIENTS_LIBENV_MAKE_OPTIONS_H_
