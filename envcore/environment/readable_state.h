#ifndef ENVCORE_ENVIRONMENT_READABLE_STATE_H_
#define ENVCORE_ENVIRONMENT_READABLE_STATE_H_

#include <string>

#include "absl/strings/string_view.h"
#include "envcore/status/status.h"

namespace procgen {

// Snapshots as JSON that people and programs read and edit. It has the fields of a snapshot
// (README.md), except:
//
//   edited     whether the state of this episode was changed by hand
//   checksum   CRC-32 of the snapshot's body; shows whether something was changed
//   agent      level.world.entities[0], without `kind`
//   entities   the others, in order
//   grid       level.world.cells as rows, the bottom row first: grid[y][x] is the kind of the cell
//              [x, x + 1) x [y, y + 1)
//
// Kinds are names (GameSpec::kinds); one that has no name is a number. An entity always has kind,
// x, y, vx, vy, rx and ry. It has `image_kind` only if that differs from its kind, and other fields
// only if they have no default value (entity.h). Floats have as few digits as 32 bits need.

// Errors: as Environment::Restore.
StatusOr<std::string> SnapshotToJson(absl::string_view snapshot);

// The inverse: the JSON of a snapshot gives the same bytes again. If something was changed, or
// there is no `checksum`, the snapshot has `edited`, and the episode's fingerprint differs from
// that of every episode that was played without a change. Numbers are rounded to 32-bit floats.
// Errors: INVALID_ARGUMENT: the text is no JSON, a field is missing, unknown or out of range, the
// grid has another size than the level, or the agent is where it cannot be (the message names the
// field, the value and what is allowed).
StatusOr<std::string> SnapshotFromJson(absl::string_view text);

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_READABLE_STATE_H_
