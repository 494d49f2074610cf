#include "tests/fuzz/snapshot_mutation.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "absl/status/statusor.h"
#include "envcore/random/random_stream.h"
#include "envcore/state/snapshot_frame.h"
#include "envcore/state/snapshot_tree.h"
#include "nlohmann/json.hpp"

namespace procgen {
namespace {

using Json = nlohmann::ordered_json;

constexpr int32_t kChangesMax = 4;
constexpr int32_t kCopiesMax = 600;

// All nodes of a tree below its root.
// NOLINTNEXTLINE(misc-no-recursion): as deep as a state
void CollectNodes(Json& node, std::vector<Json*>* nodes) {
  if (node.is_structured()) {
    for (Json& child : node) {
      nodes->push_back(&child);
      CollectNodes(child, nodes);
    }
  }
}

void ChangeInteger(Json& node, RandomStream& random) {
  const std::vector<int64_t> values = {std::numeric_limits<int32_t>::min(),
                                       -1000000,
                                       -2,
                                       -1,
                                       0,
                                       1,
                                       2,
                                       3,
                                       7,
                                       8,
                                       10,
                                       51,
                                       52,
                                       54,
                                       59,
                                       99,
                                       100,
                                       101,
                                       1000,
                                       1000000,
                                       std::numeric_limits<int32_t>::max()};
  const int64_t number = node.is_number_unsigned() && node.get<uint64_t>() > INT32_MAX
                             ? INT32_MAX
                             : node.get<int64_t>();
  switch (random.Int(3)) {
    case 0:
      node = random.OneOf(values);
      break;
    case 1:
      node = number + random.Int(-3, 4);
      break;
    default:
      node = random.Int(100);
      break;
  }
}

void ChangeFloat(Json& node, RandomStream& random) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<float> values = {0,    -0.0F, 1e-30F, 0.1F,  0.4F,      0.5F,         1,
                                     1.5F, 2,     7.99F,  8,     16,        64,           256,
                                     999,  1000,  1e6F,   3e38F, kInfinity, std::nanf("")};
  const auto number = static_cast<float>(node.get<double>());
  float changed = 0;
  switch (random.Int(4)) {
    case 0:
      changed = random.OneOf(values);
      break;
    case 1:
      changed = std::floor(number) + static_cast<float>(random.Int(3)) * 0.5F;
      break;
    case 2:
      changed = number + random.Range(-1, 1);
      break;
    default:
      changed = random.Range(-64, 64);
      break;
  }
  node = random.Coin() ? changed : -changed;
}

// Removes, duplicates, multiplies or swaps an entry of a list.
void ChangeList(Json& list, RandomStream& random) {
  if (list.empty()) {
    return;
  }
  const auto entry = static_cast<size_t>(random.Int(static_cast<int32_t>(list.size())));
  const auto other = static_cast<size_t>(random.Int(static_cast<int32_t>(list.size())));
  switch (random.Int(4)) {
    case 0:
      list.erase(entry);
      break;
    case 1:
      list.push_back(Json(list[entry]));
      break;
    case 2: {
      const Json copied = list[entry];
      list.insert(list.end(), static_cast<size_t>(random.Int(kCopiesMax)), copied);
      break;
    }
    default:
      std::swap(list[entry], list[other]);
      break;
  }
}

void ChangeGroup(Json& group, RandomStream& random) {
  if (!group.empty()) {
    auto field = group.begin();
    std::advance(field, random.Int(static_cast<int32_t>(group.size())));
    group.erase(field.key());
  }
}

// Entity fields that a snapshot omits if they have their default.
void AddEntityField(Json& entity, RandomStream& random) {
  const std::vector<Json::object_t::value_type> fields = {
      {"vx", 1.0},        {"vy", -1.0},      {"layer", 1},      {"meets_entities", true},
      {"smart", true},    {"growth", 1.25},  {"expiry", 30},    {"auto_remove", false},
      {"marked", true},   {"spin", 0.5},     {"rotation", 1.0}, {"contact_margin", 0.5},
      {"health", 2.0},    {"angle", 1.0},    {"opacity", 0.5},  {"screen_coordinates", true},
      {"mirrored", true}, {"fading", 0.5},   {"friction", 0.5}, {"patrol_center", 3.0},
      {"shot_step", 5},   {"spawn_step", 5}, {"life_time", 5},  {"avoids_collisions", true},
      {"theme", 3}};
  const auto& [name, value] = random.OneOf(fields);
  entity[name] = value;
}

void ChangeSomething(Json& root, RandomStream& random) {
  std::vector<Json*> nodes;
  CollectNodes(root, &nodes);
  if (nodes.empty()) {
    return;
  }
  Json& node = *random.OneOf(nodes);
  if (random.Int(16) == 0) {
    const Json copied = *random.OneOf(nodes);
    node = copied;
  } else if (node.is_boolean()) {
    node = !node.get<bool>();
  } else if (node.is_number_float()) {
    ChangeFloat(node, random);
  } else if (node.is_number()) {
    ChangeInteger(node, random);
  } else if (node.is_array()) {
    ChangeList(node, random);
  } else if (node.is_object() && node.contains("image_kind") && random.Int(8) != 0) {
    AddEntityField(node, random);
  } else if (node.is_object()) {
    ChangeGroup(node, random);
  }
}

}  // namespace

std::string MutatedSnapshot(absl::string_view snapshot, uint32_t seed, size_t length_max) {
  // Rejects bytes that are not a tree within the limits.
  if (!ParseSnapshot(snapshot).ok()) {
    return "";
  }
  const absl::string_view body = snapshot.substr(kSnapshotHeaderBytes);
  Json root = Json::from_cbor(body.begin(), body.end());
  RandomStream random(seed);
  for (int32_t changes = 1 + random.Int(kChangesMax); changes > 0; --changes) {
    ChangeSomething(root, random);
  }
  std::string changed;
  Json::to_cbor(root, changed);
  return changed.size() + kSnapshotHeaderBytes > length_max ? "" : FrameSnapshot(changed);
}

}  // namespace procgen
