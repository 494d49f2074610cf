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

// The shape of a tensor that is not a picture: [] or [N].
struct TensorShape {
  static constexpr int32_t kAnyLength = -1;

  static constexpr TensorShape Scalar() { return {}; }
  static constexpr TensorShape List(int32_t length) { return {true, length}; }

  int32_t element_count() const { return is_list ? length : 1; }

  bool is_list = false;
  int32_t length = 0;
};

// The functions below read and check `tensor`, the value of `field`. Those with a `shape` return
// `shape.element_count()` elements: a single element is broadcast to the list, and a negative
// dimension is inferred from the number of elements.
// Errors: INVALID_ARGUMENT wrong type, shape or value (the message has `field`, the given and the
// allowed one).

// Of type INT32. REQUIRES: no kAnyLength.
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
// A finite scalar of any numeric type.
absl::StatusOr<double> ReadNumber(absl::string_view field, const dm::Tensor& tensor);
// A scalar of type STRING.
absl::StatusOr<std::string> ReadText(absl::string_view field, const dm::Tensor& tensor);
// A scalar or a list of type STRING.
absl::StatusOr<std::vector<std::string>> ReadTexts(absl::string_view field,
                                                   const dm::Tensor& tensor);
// A list of type UINT8. The result points into `tensor`.
absl::StatusOr<absl::string_view> ReadBytes(absl::string_view field, const dm::Tensor& tensor);

// Text of a client, truncated at a character boundary for use in messages.
std::string Truncated(absl::string_view text);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_TENSOR_H_
