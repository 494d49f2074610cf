#include "envcore/state/snapshot_tree.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "envcore/state/snapshot_frame.h"

namespace procgen {
namespace {

using Json = SnapshotTree;

constexpr size_t kDepthMax = 8;            // nested groups and lists
constexpr size_t kValueCountMax = 250000;  // values in a snapshot
// Fields in a group. The largest group, an entity without omitted fields, has 31. Fields are found
// by linear search, so the time to build a group is quadratic in this.
constexpr size_t kGroupFieldCountMax = 64;
constexpr size_t kSizeUnknown = std::numeric_limits<size_t>::max();  // reported by the parser as -1

// Checks depth and size of a body before it is built.
class BoundsCheck : public nlohmann::json_sax<Json> {
 public:
  // The exceeded limit; empty if there is none.
  const std::string& excess() const { return excess_; }

  bool null() override { return Exceeds("it has a null value"); }
  bool boolean(bool /*value*/) override { return Count(); }
  bool number_integer(number_integer_t /*value*/) override { return Count(); }
  bool number_unsigned(number_unsigned_t /*value*/) override { return Count(); }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override { return Count(); }
  bool string(string_t& /*value*/) override { return Count(); }
  bool binary(binary_t& /*value*/) override { return false; }
  bool start_object(size_t size) override {
    if (size > kGroupFieldCountMax) {
      const std::string count = size == kSizeUnknown ? "an unknown number of" : absl::StrCat(size);
      return Exceeds(absl::StrCat("a group has ", count, " fields, at most ", kGroupFieldCountMax,
                                  " are allowed"));
    }
    return Enter();
  }
  bool key(string_t& /*name*/) override { return true; }
  bool end_object() override { return Leave(); }
  // A list of unknown size exceeds the limit.
  bool start_array(size_t size) override { return size <= kValueCountMax ? Enter() : Count(size); }
  bool end_array() override { return Leave(); }
  bool parse_error(size_t /*position*/, const std::string& /*token*/,
                   const Json::exception& /*error*/) override {
    return false;
  }

 private:
  bool Exceeds(std::string bound) {
    excess_ = std::move(bound);
    return false;
  }
  bool Count(size_t values = 1) {
    value_count_ += std::min(values, kValueCountMax + 1);
    return value_count_ <= kValueCountMax ||
           Exceeds(absl::StrCat("it has more than ", kValueCountMax, " values"));
  }
  bool Enter() {
    if (++depth_ > kDepthMax) {
      return Exceeds(absl::StrCat("it is nested more than ", kDepthMax, " deep"));
    }
    return Count();
  }
  bool Leave() {
    --depth_;
    return true;
  }

  size_t depth_ = 0;
  size_t value_count_ = 0;
  std::string excess_;
};

}  // namespace

StatusOr<SnapshotTree> ParseSnapshot(absl::string_view snapshot) {
  const StatusOr<absl::string_view> body = UnframeSnapshot(snapshot);
  if (!body.ok()) {
    return body.status();
  }
  BoundsCheck bounds;
  try {
    if (Json::sax_parse(body->begin(), body->end(), &bounds, Json::input_format_t::cbor)) {
      Json root = Json::from_cbor(body->begin(), body->end(), true, /*allow_exceptions=*/false);
      if (root.is_object()) {
        return root;
      }
    }
  } catch (const std::exception&) {
    // Reported below.
  }
  return DataLossError(absl::StrCat("the snapshot's body is not a group of fields in CBOR",
                                    bounds.excess().empty() ? "" : ": ", bounds.excess()));
}

std::string SerializeSnapshot(const SnapshotTree& tree) {
  std::string body;
  Json::to_cbor(tree, body);
  return FrameSnapshot(body);
}

}  // namespace procgen
