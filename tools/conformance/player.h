#ifndef TOOLS_CONFORMANCE_PLAYER_H_
#define TOOLS_CONFORMANCE_PLAYER_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "envcore/pool/shared_art.h"
#include "envcore/trace/trace.h"

namespace procgen {

// The results of E environments after a step, or after their creation.
struct Observations {
  std::vector<float> rewards;                // [E]
  std::vector<uint8_t> first;                // [E]
  std::vector<int32_t> level_seeds;          // [E]
  std::vector<int32_t> prev_level_seeds;     // [E]
  std::vector<uint8_t> prev_level_complete;  // [E]
  std::vector<uint8_t> observations;         // [E, 64, 64, 3], or empty
};

// Returns the arrays of `observed`, resized to `env_count` rows.
Batch BatchOf(Observations* observed, int32_t env_count, bool with_pictures);

// The pool of a trace, with the built-in art.
PoolOptions PoolOptionsOf(const Trace& trace);

// Plays the environments of a trace, in this process or on a server.
class Player {
 public:
  virtual ~Player() = default;
  // Returns the results before the first step.
  virtual absl::Status Observe(Observations* observed) = 0;
  virtual absl::Status Step(absl::Span<const int32_t> actions, Observations* observed) = 0;
};

// Makes a player in this process with `worker_count` >= 1 workers. `art`: the art to draw with;
// null: the built-in art. Errors: as Pool::Create.
absl::StatusOr<std::unique_ptr<Player>> MakeLocalPlayer(const Trace& trace, int32_t worker_count,
                                                        bool with_pictures,
                                                        std::shared_ptr<const SharedArt> art);

// Makes a player on a server, which draws with its own art. `addresses`: several are separated by
// commas. Errors: those of the server.
absl::StatusOr<std::unique_ptr<Player>> MakeRemotePlayer(const Trace& trace,
                                                         const std::string& addresses,
                                                         bool with_pictures);

}  // namespace procgen

#endif  // TOOLS_CONFORMANCE_PLAYER_H_
