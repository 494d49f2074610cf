#ifndef ENVCORE_STATE_STATE_ARCHIVE_H_
#define ENVCORE_STATE_STATE_ARCHIVE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/strings/string_view.h"
#include "envcore/status/status.h"

namespace procgen {

// Saves or restores state field by field. A type describes its state once, in one function for both
// directions, so saving and restoring cannot differ:
//
//   void Visit(StateArchive& archive, Ball& ball) {
//     archive.Float("x", ball.x, -10, 10);
//     archive.Int("bounces", ball.bounces, 0, 100, /*absent=*/0);
//   }
//
// Every field has a name, unique in its group and valid as long as the archive, and an inclusive
// range. A field with `absent` is
// omitted from the snapshot when it has exactly that value.
//
// Errors: the first error is kept, and nothing is visited after it. While restoring,
// INVALID_ARGUMENT: a field is missing, unknown, of another type or out of range (the message gives
// its path and what is allowed). While saving, INTERNAL: a value is out of range, unless the
// archive saturates. After an error, discard the restored objects: they may be partly restored.
// Threads: compatible (one thread at a time).
class StateArchive {
 public:
  // What saving does with a number out of range.
  enum class OutOfRange {
    kFails,      // returns an error: the games never reach such a value, so it is a bug
    kSaturates,  // clamps the number, in the snapshot and in the visited object
  };

  // Makes an archive that saves. One that saturates changes the visited objects too, so that they
  // continue like an object restored from the snapshot.
  explicit StateArchive(OutOfRange out_of_range = OutOfRange::kFails);
  // How numbers of a snapshot become 32-bit floats.
  enum class Floats {
    kExact,    // a number that is no 32-bit float is an error
    kRounded,  // integers and 64-bit floats are rounded to the nearest: people wrote them
  };

  // Makes an archive that restores from `snapshot`, which may be freed afterwards. Memory is
  // bounded by a small multiple of kSnapshotBytesMax. Errors: DATA_LOSS: not a complete snapshot.
  static StatusOr<StateArchive> Open(absl::string_view snapshot, Floats floats = Floats::kExact);
  ~StateArchive();
  StateArchive(StateArchive&& other) noexcept;
  StateArchive& operator=(StateArchive&& other) noexcept;

  bool restores() const { return restores_; }
  bool saturates() const { return saturates_; }
  bool ok() const { return status_.ok(); }
  const Status& status() const { return status_; }
  // Returns the saved snapshot. Errors: status(); INTERNAL: it is larger than kSnapshotBytesMax.
  // REQUIRES: !restores(); no group is open.
  StatusOr<std::string> Finish() const;
  // Returns status(), or an error if fields of the snapshot were not read. REQUIRES: restores(); no
  // group is open.
  Status Close();

  void Bool(absl::string_view name, bool& value, std::optional<bool> absent = std::nullopt);
  void Int(absl::string_view name, int32_t& value, int32_t low, int32_t high,
           std::optional<int32_t> absent = std::nullopt);
  void Float(absl::string_view name, float& value, float low, float high,
             std::optional<float> absent = std::nullopt);
  // An unsigned 64-bit number in [0, high].
  void Bits(absl::string_view name, uint64_t& value, uint64_t high = UINT64_MAX);
  void Text(absl::string_view name, std::string& value, size_t length_max);
  // A list of numbers. Its length is checked before memory is allocated.
  void Ints(absl::string_view name, std::vector<int32_t>& values, size_t count_max, int32_t low,
            int32_t high);

  // A group of fields.
  void Group(absl::string_view name, absl::FunctionRef<void()> visit);
  // A list of groups. Its length is checked before memory is allocated.
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

  // Fails with "<path of the open group> <reason>" unless `holds`. For conditions that ranges
  // cannot express.
  void Check(bool holds, absl::string_view reason);

 private:
  struct Tree;

  // Returns the number of groups to visit: `count` while saving.
  size_t BeginList(absl::string_view name, size_t count, size_t count_min, size_t count_max);
  void EndList();
  void BeginItem(size_t index);
  void EndItem();
  // Fails if fields of the innermost group were not read.
  void CheckAllRead();
  void Fail(absl::string_view name, absl::string_view reason);
  std::string PathOf(absl::string_view name) const;

  // Clamps `value` if the archive saturates. NaN becomes `low`.
  template <typename T>
  void Saturate(T& value, T low, T high) const {
    if (saturates_ && !(value >= low && value <= high)) {
      value = value > high ? high : low;
    }
  }

  bool restores_ = false;
  bool saturates_ = false;
  bool rounds_floats_ = false;
  Status status_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace procgen

#endif  // ENVCORE_STATE_STATE_ARCHIVE_H_
