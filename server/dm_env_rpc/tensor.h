#ifndef SERVER_DM_ENV_RPC_TENSOR_H_
#define SERVER_DM_ENV_RPC_TENSOR_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "dm_env_rpc/v1/dm_env_rpc.pb.h"

namespace procgen {

// The messages of the protocol.
namespace dm = ::dm_env_rpc::v1;

// The shapes that tensors have here, but for pictures: [] and [N].
struct TensorShape {
  static constexpr int32_t kAnyLength = -1;

  static constexpr TensorShape Scalar() { return {}; }
  static constexpr TensorShape List(int32_t length) { return {true, length}; }

  int32_t element_count() const { return is_list ? length : 1; }

  bool is_list = false;
  int32_t length = 0;
};

// What was given for `field` as a tensor, checked: `shape.element_count()` elements. A single one
// is taken for a whole list, and a negative dimension follows from the number of elements. Errors:
// INVALID_ARGUMENT another type, shape or value (the message names `field`, what was given and what
// is allowed).

// Of exactly INT32. REQUIRES: no kAnyLength.
absl::StatusOr<std::vector<int32_t>> ReadInt32s(absl::string_view field, const dm::Tensor& tensor,
                                                TensorShape shape);
// Of any integer type. REQUIRES: no kAnyLength.
absl::StatusOr<std::vector<int64_t>> ReadIntegers(absl::string_view field, const dm::Tensor& tensor,
                                                  TensorShape shape);
// Of any integer type, each in the range of int32. REQUIRES: no kAnyLength.
absl::StatusOr<std::vector<int32_t>> ReadIntegersAsInt32s(absl::string_view field,
                                                          const dm::Tensor& tensor,
                                                          TensorShape shape);
// A scalar of any integer type, in [min, max].
absl::StatusOr<int64_t> ReadInteger(absl::string_view field, const dm::Tensor& tensor, int64_t min,
                                    int64_t max);
// A scalar of type BOOL, or an integer that is 0 or 1.
absl::StatusOr<bool> ReadBool(absl::string_view field, const dm::Tensor& tensor);
// A scalar of any type of numbers; finite.
absl::StatusOr<double> ReadNumber(absl::string_view field, const dm::Tensor& tensor);
// A scalar of type STRING.
absl::StatusOr<std::string> ReadText(absl::string_view field, const dm::Tensor& tensor);
// A scalar or a list of type STRING.
absl::StatusOr<std::vector<std::string>> ReadTexts(absl::string_view field,
                                                   const dm::Tensor& tensor);
// A list of type UINT8; it lies in `tensor`.
absl::StatusOr<absl::string_view> ReadBytes(absl::string_view field, const dm::Tensor& tensor);

// A text that somebody sent, as far as messages repeat it.
std::string Shown(absl::string_view text);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_TENSOR_H_
