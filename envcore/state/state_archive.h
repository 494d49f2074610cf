#ifndef ENVCORE_STATE_STATE_ARCHIVE_H_
#define ENVCORE_STATE_STATE_ARCHIVE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen {

// Visits the state of things, field by field, and either saves or restores it. What has a state
// describes it once, in one function, so that saving and restoring cannot disagree:
//
//   void Visit(StateArchive& archive, Ball& ball) {
//     archive.Float("x", ball.x, -10, 10);
//     archive.Int("bounces", ball.bounces, 0, 100, /*absent=*/0);
//   }
//
// Every field has a name, unique in its group, and a range, both ends of which belong to it. A
// field with `absent` is left out of the snapshot where it has that value, to the last bit.
//
// Errors: the first one stays, and from then on nothing is visited any more. While restoring:
// INVALID_ARGUMENT a field that is missing, unknown, of another type or out of range, with its
// path and what is allowed. While saving: INTERNAL a value out of range, unless the archive
// saturates. What an archive that failed has restored may be half of each state and must be thrown
// away.
// Threads: compatible (one thread at a time).
class StateArchive {
 public:
  // What saving does with a number out of range.
  enum class OutOfRange {
    kFails,      // it is a bug: nothing that was played gets there
    kSaturates,  // it becomes the nearest in range, in the snapshot and in what is visited
  };

  // An archive that saves. One that saturates changes what is visited, so that it continues as what
  // is restored from the snapshot does.
  explicit StateArchive(OutOfRange out_of_range = OutOfRange::kFails);
  // One that restores from `snapshot`, which need not stay. Memory is bounded by a small multiple
  // of kSnapshotBytesMax, whatever the bytes. Errors: DATA_LOSS they are no whole snapshot.
  static absl::StatusOr<StateArchive> Open(absl::string_view snapshot);
  ~StateArchive();
  StateArchive(StateArchive&& other) noexcept;
  StateArchive& operator=(StateArchive&& other) noexcept;

  bool restores() const { return restores_; }
  bool saturates() const { return saturates_; }
  bool ok() const { return status_.ok(); }
  const absl::Status& status() const { return status_; }
  // The snapshot that was saved. Errors: status(); INTERNAL it is longer than a snapshot can be.
  // REQUIRES: !restores(), and no group is open.
  absl::StatusOr<std::string> Finish() const;
  // status(), and that nothing in the snapshot was left unread. REQUIRES: restores(), and no group
  // is open.
  absl::Status Close();

  void Bool(absl::string_view name, bool& value, std::optional<bool> absent = std::nullopt);
  void Int(absl::string_view name, int32_t& value, int32_t low, int32_t high,
           std::optional<int32_t> absent = std::nullopt);
  void Float(absl::string_view name, float& value, float low, float high,
             std::optional<float> absent = std::nullopt);
  // An unsigned number of 64 bits in [0, high].
  void Bits(absl::string_view name, uint64_t& value, uint64_t high = UINT64_MAX);
  void Text(absl::string_view name, std::string& value, size_t length_max);
  // A list of numbers. Its length is checked before it is made.
  void Ints(absl::string_view name, std::vector<int32_t>& values, size_t count_max, int32_t low,
            int32_t high);

  // A group of fields.
  void Group(absl::string_view name, absl::FunctionRef<void()> visit);
  // A list of groups. Its length is checked before it is made.
  template <typename T>
  void Groups(absl::string_view name, std::vector<T>& list, size_t count_min, size_t count_max,
              absl::FunctionRef<void(T&)> visit) {
    const size_t count = BeginList(name, list.size(), count_min, count_max);
    if (restores_) {
      list.clear();
      list.resize(count);
    }
    for (size_t i = 0; i < count && ok(); ++i) {
      BeginItem(i);
      visit(list[i]);
      EndItem();
    }
    EndList();
  }

  // For what ranges do not tell: fails with "<path of the open group> <reason>" unless `holds`.
  void Check(bool holds, absl::string_view reason);

 private:
  struct Tree;

  // The number of groups to visit: `count` while saving.
  size_t BeginList(absl::string_view name, size_t count, size_t count_min, size_t count_max);
  void EndList();
  void BeginItem(size_t index);
  void EndItem();
  // Fails if fields of the innermost group were not read.
  void CheckAllRead();
  void Fail(absl::string_view name, absl::string_view reason);
  std::string PathOf(absl::string_view name) const;

  // Where the archive saturates, `value` becomes the nearest in range; not a number becomes `low`.
  template <typename T>
  void Saturate(T& value, T low, T high) const {
    if (saturates_ && !(value >= low && value <= high)) {
      value = value > high ? high : low;
    }
  }

  bool restores_ = false;
  bool saturates_ = false;
  absl::Status status_;
  std::unique_ptr<Tree> tree_;
};

// What a snapshot holds, as indented JSON for people. Floats are written with the digits that give
// them back. Errors: as StateArchive::Open.
absl::StatusOr<std::string> SnapshotAsJson(absl::string_view snapshot);

}  // namespace procgen

#endif  // ENVCORE_STATE_STATE_ARCHIVE_H_
