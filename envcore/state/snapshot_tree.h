#ifndef ENVCORE_STATE_SNAPSHOT_TREE_H_
#define ENVCORE_STATE_SNAPSHOT_TREE_H_

#include <string>

#include "absl/strings/string_view.h"
#include "envcore/status/status.h"
#include "nlohmann/json.hpp"

namespace procgen {

// The named fields of a snapshot, in their order.
using SnapshotTree = nlohmann::ordered_json;

// Returns the content of a snapshot, with bounded depth and number of values. Errors: DATA_LOSS:
// not a complete snapshot.
StatusOr<SnapshotTree> ParseSnapshot(absl::string_view snapshot);
// Returns the snapshot of a tree. It may exceed kSnapshotBytesMax.
std::string SerializeSnapshot(const SnapshotTree& tree);

}  // namespace procgen

#endif  // ENVCORE_STATE_SNAPSHOT_TREE_H_
