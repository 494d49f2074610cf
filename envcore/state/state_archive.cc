#include "envcore/state/state_archive.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "envcore/state/snapshot_frame.h"
#include "envcore/state/snapshot_tree.h"

namespace procgen {
namespace {

using Json = SnapshotTree;

// The integer in `node`. Values beyond 63 bits become INT64_MAX, which is out of every range.
int64_t IntegerIn(const Json& node) {
  const bool is_huge =
      node.is_number_unsigned() && node.get<uint64_t>() > std::numeric_limits<int64_t>::max();
  return is_huge ? std::numeric_limits<int64_t>::max() : node.get<int64_t>();
}

template <typename T>
std::string NotInRange(T value, T low, T high) {
  return absl::StrCat("is ", value, ", must be in [", low, ", ", high, "]");
}

bool SameBits(float a, float b) { return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b); }

}  // namespace

// The tree and the path to the open group.
struct StateArchive::Tree {
  struct Level {
    Json* node;
    std::string name;
    std::vector<absl::string_view> known = {};  // names of the fields that were visited
    size_t fields_read = 0;
  };

  explicit Tree(Json json) : root(std::move(json)) { way.push_back({&root, ""}); }

  // Returns the value of a field and marks it as read; null if there is none.
  const Json* Read(absl::string_view name) {
    Level& level = way.back();
    level.known.push_back(name);
    const auto found = level.node->find(std::string(name));
    if (found == level.node->end()) {
      return nullptr;
    }
    ++level.fields_read;
    return &*found;
  }
  Json& Write(absl::string_view name, Json value) {
    return (*way.back().node)[std::string(name)] = std::move(value);
  }
  void Enter(const Json& node, absl::string_view name) {
    way.push_back({const_cast<Json*>(&node), std::string(name)});
  }

  Json root;
  std::vector<Level> way;
};

StateArchive::StateArchive(OutOfRange out_of_range)
    : saturates_(out_of_range == OutOfRange::kSaturates),
      tree_(std::make_unique<Tree>(Json::object())) {}

StatusOr<StateArchive> StateArchive::Open(absl::string_view snapshot, Floats floats) {
  StatusOr<Json> root = ParseSnapshot(snapshot);
  if (!root.ok()) {
    return root.status();
  }
  StateArchive archive;
  archive.restores_ = true;
  archive.rounds_floats_ = floats == Floats::kRounded;
  archive.tree_ = std::make_unique<Tree>(*std::move(root));
  return archive;
}

StateArchive::~StateArchive() = default;
StateArchive::StateArchive(StateArchive&& other) noexcept = default;
StateArchive& StateArchive::operator=(StateArchive&& other) noexcept = default;

StatusOr<std::string> StateArchive::Finish() const {
  if (!ok()) {
    return status_;
  }
  std::string snapshot = SerializeSnapshot(tree_->root);
  if (snapshot.size() > kSnapshotBytesMax) {
    return InternalError(absl::StrCat("the snapshot would have ", snapshot.size(),
                                      " bytes, a snapshot has at most ", kSnapshotBytesMax));
  }
  return snapshot;
}

Status StateArchive::Close() {
  if (ok()) {
    CheckAllRead();
  }
  return status_;
}

void StateArchive::Bool(absl::string_view name, bool& value, std::optional<bool> absent) {
  if (!ok()) {
    return;
  }
  if (!restores_) {
    if (value != absent) {
      tree_->Write(name, value);
    }
    return;
  }
  const Json* node = tree_->Read(name);
  if (node == nullptr && absent.has_value()) {
    value = *absent;
  } else if (node == nullptr || !node->is_boolean()) {
    Fail(name, node == nullptr ? "is missing" : "is not a boolean");
  } else {
    value = node->get<bool>();
  }
}

void StateArchive::Int(absl::string_view name, int32_t& value, int32_t low, int32_t high,
                       std::optional<int32_t> absent) {
  if (!ok()) {
    return;
  }
  Saturate(value, low, high);
  int64_t number = value;
  if (restores_) {
    const Json* node = tree_->Read(name);
    if (node == nullptr && absent.has_value()) {
      value = *absent;
      return;
    }
    if (node == nullptr || !node->is_number_integer()) {
      return Fail(name, node == nullptr ? "is missing" : "is not an integer");
    }
    number = IntegerIn(*node);
  }
  if (number < low || number > high) {
    return Fail(name, NotInRange(number, int64_t{low}, int64_t{high}));
  }
  if (restores_) {
    value = static_cast<int32_t>(number);
  } else if (value != absent) {
    tree_->Write(name, value);
  }
}

void StateArchive::Float(absl::string_view name, float& value, float low, float high,
                         std::optional<float> absent) {
  if (!ok()) {
    return;
  }
  Saturate(value, low, high);
  auto number = static_cast<double>(value);
  if (restores_) {
    const Json* node = tree_->Read(name);
    if (node == nullptr && absent.has_value()) {
      value = *absent;
      return;
    }
    const bool is_number =
        node != nullptr && (node->is_number_float() || (rounds_floats_ && node->is_number()));
    if (!is_number) {
      return Fail(name, node == nullptr ? "is missing" : "is not a float");
    }
    number = node->get<double>();
    if (rounds_floats_) {
      number = static_cast<double>(static_cast<float>(number));
    }
  }
  // NaN is out of every range.
  if (!(number >= static_cast<double>(low) && number <= static_cast<double>(high))) {
    return Fail(name, NotInRange(number, static_cast<double>(low), static_cast<double>(high)));
  }
  if (!restores_) {
    if (!absent.has_value() || !SameBits(value, *absent)) {
      tree_->Write(name, number);
    }
    return;
  }
  if (static_cast<double>(static_cast<float>(number)) != number) {
    return Fail(name, "is not representable as a 32-bit float");
  }
  value = static_cast<float>(number);
}

void StateArchive::Bits(absl::string_view name, uint64_t& value, uint64_t high) {
  if (!ok()) {
    return;
  }
  Saturate(value, uint64_t{0}, high);
  uint64_t number = value;
  if (restores_) {
    const Json* node = tree_->Read(name);
    if (node == nullptr || !node->is_number_unsigned()) {
      return Fail(name, node == nullptr ? "is missing" : "is not an integer of at least 0");
    }
    number = node->get<uint64_t>();
  }
  if (number > high) {
    return Fail(name, NotInRange(number, uint64_t{0}, high));
  }
  if (restores_) {
    value = number;
  } else {
    tree_->Write(name, value);
  }
}

void StateArchive::Text(absl::string_view name, std::string& value, size_t length_max) {
  if (!ok()) {
    return;
  }
  if (!restores_) {
    tree_->Write(name, value);
    return;
  }
  const Json* node = tree_->Read(name);
  if (node == nullptr || !node->is_string()) {
    return Fail(name, node == nullptr ? "is missing" : "is not a string");
  }
  const auto& text = node->get_ref<const std::string&>();
  if (text.size() > length_max) {
    return Fail(name,
                absl::StrCat("has ", text.size(), " bytes, at most ", length_max, " are allowed"));
  }
  value = text;
}

void StateArchive::Ints(absl::string_view name, std::vector<int32_t>& values, size_t count_max,
                        int32_t low, int32_t high) {
  const size_t count = BeginList(name, values.size(), 0, count_max);
  if (restores_) {
    values.assign(count, 0);
  }
  for (size_t i = 0; i < count && ok(); ++i) {
    Json& list = *tree_->way.back().node;
    if (restores_ && !list[i].is_number_integer()) {
      return Fail(absl::StrCat("[", i, "]"), "is not an integer");
    }
    const int64_t number = restores_ ? IntegerIn(list[i]) : values[i];
    if (number < low || number > high) {
      return Fail(absl::StrCat("[", i, "]"), NotInRange(number, int64_t{low}, int64_t{high}));
    }
    if (restores_) {
      values[i] = static_cast<int32_t>(number);
    } else {
      list.push_back(number);
    }
  }
  EndList();
}

void StateArchive::Group(absl::string_view name, absl::FunctionRef<void()> visit) {
  if (!ok()) {
    return;
  }
  if (restores_) {
    const Json* node = tree_->Read(name);
    if (node == nullptr || !node->is_object()) {
      return Fail(name, node == nullptr ? "is missing" : "is not a group");
    }
    tree_->Enter(*node, name);
  } else {
    tree_->Enter(tree_->Write(name, Json::object()), name);
  }
  visit();
  EndItem();
}

size_t StateArchive::BeginList(absl::string_view name, size_t count, size_t count_min,
                               size_t count_max) {
  if (!ok()) {
    return 0;
  }
  const Json* node = nullptr;
  if (restores_) {
    node = tree_->Read(name);
    if (node == nullptr || !node->is_array()) {
      Fail(name, node == nullptr ? "is missing" : "is not a list");
      return 0;
    }
    count = node->size();
  }
  if (count < count_min || count > count_max) {
    Fail(name,
         absl::StrCat("has ", count, " entries, must have from ", count_min, " to ", count_max));
    return 0;
  }
  tree_->Enter(restores_ ? *node : tree_->Write(name, Json::array()), name);
  return count;
}

void StateArchive::EndList() {
  if (ok()) {
    tree_->way.pop_back();
  }
}

void StateArchive::BeginItem(size_t index) {
  Json& list = *tree_->way.back().node;
  if (!restores_) {
    list.push_back(Json::object());
  }
  if (!list[index].is_object()) {
    return Fail(absl::StrCat("[", index, "]"), "is not a group");
  }
  tree_->Enter(list[index], absl::StrCat("[", index, "]"));
}

void StateArchive::EndItem() {
  if (!ok()) {
    return;
  }
  CheckAllRead();
  if (ok()) {
    tree_->way.pop_back();
  }
}

void StateArchive::CheckAllRead() {
  const Tree::Level& level = tree_->way.back();
  if (!restores_ || level.fields_read == level.node->size()) {
    return;
  }
  for (const auto& field : level.node->items()) {
    if (std::find(level.known.begin(), level.known.end(), field.key()) == level.known.end()) {
      return Fail("", absl::StrCat("has the unknown field ", field.key(), "; its fields are ",
                                   absl::StrJoin(level.known, ", ")));
    }
  }
  Fail("", "has a field twice");
}

void StateArchive::Check(bool holds, absl::string_view reason) {
  if (!holds && ok()) {
    Fail("", reason);
  }
}

void StateArchive::Fail(absl::string_view name, absl::string_view reason) {
  const std::string message = absl::StrCat(PathOf(name), " ", reason);
  status_ = restores_ ? InvalidArgumentError(message) : InternalError(message);
}

std::string StateArchive::PathOf(absl::string_view name) const {
  std::string path;
  const auto append = [&path](absl::string_view part) {
    const bool apart = !path.empty() && !part.empty() && part.front() != '[';
    absl::StrAppend(&path, apart ? "." : "", part);
  };
  for (const Tree::Level& level : tree_->way) {
    append(level.name);
  }
  append(name);
  return path.empty() ? "the snapshot" : path;
}

}  // namespace procgen
