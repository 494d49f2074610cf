#include "server/dm_env_rpc/tensor.h"

#include <algorithm>
#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/types/span.h"

namespace procgen {
namespace {

constexpr size_t kTextBytesMax = 64;
constexpr int kShownDimensionsMax = 8;

std::string TypeName(const dm::Tensor& tensor) {
  // A payload's field number equals its DataType.
  const auto type = static_cast<int>(tensor.payload_case());
  return type == 0 ? "none" : dm::DataType_Name(type);
}

absl::Status WrongType(absl::string_view field, const dm::Tensor& tensor,
                       absl::string_view allowed) {
  return absl::InvalidArgumentError(
      absl::StrCat(field, " has type ", TypeName(tensor), ", allowed: ", allowed));
}

std::string ShapeText(const dm::Tensor& tensor) {
  const int shown = std::min(tensor.shape_size(), kShownDimensionsMax);
  return absl::StrCat("[",
                      absl::StrJoin(tensor.shape().begin(), tensor.shape().begin() + shown, ", "),
                      shown < tensor.shape_size() ? ", ...]" : "]");
}

std::string ShapeText(TensorShape shape) {
  if (!shape.is_list) {
    return "[]";
  }
  return shape.length == TensorShape::kAnyLength ? "[N] with N elements"
                                                 : absl::StrCat("[", shape.length, "]");
}

bool HasShape(const dm::Tensor& tensor, int64_t given, TensorShape shape) {
  if (!shape.is_list) {
    return tensor.shape_size() == 0 && given == 1;
  }
  if (tensor.shape_size() != 1) {
    return false;
  }
  const int64_t length = tensor.shape(0) < 0 ? given : tensor.shape(0);
  if (shape.length == TensorShape::kAnyLength) {
    return length == given;
  }
  return length == shape.length && (given == length || given == 1);
}

absl::Status CheckShape(absl::string_view field, const dm::Tensor& tensor, int64_t given,
                        TensorShape shape) {
  if (HasShape(tensor, given, shape)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(field, " has shape ", ShapeText(tensor), " and ",
                                                 given, " elements, allowed: shape ",
                                                 ShapeText(shape)));
}

absl::Status CheckRange(absl::string_view field, int64_t value, int64_t min, int64_t max) {
  if (value < min || value > max) {
    return absl::InvalidArgumentError(
        absl::StrCat(field, " is ", value, ", allowed: ", min, " to ", max));
  }
  return absl::OkStatus();
}

template <typename Element, typename Elements>
absl::StatusOr<std::vector<Element>> Read(absl::string_view field, const dm::Tensor& tensor,
                                          const Elements& elements, TensorShape shape) {
  const auto given = static_cast<int64_t>(elements.size());
  if (absl::Status status = CheckShape(field, tensor, given, shape); !status.ok()) {
    return status;
  }
  if (given == 1 && shape.is_list && shape.length != TensorShape::kAnyLength) {
    return std::vector<Element>(static_cast<size_t>(shape.length), *elements.begin());
  }
  return std::vector<Element>(elements.begin(), elements.end());
}

// Returns the element of a scalar.
template <typename Element, typename Elements>
absl::StatusOr<Element> ReadScalar(absl::string_view field, const dm::Tensor& tensor,
                                   const Elements& elements) {
  const auto given = static_cast<int64_t>(elements.size());
  if (absl::Status status = CheckShape(field, tensor, given, TensorShape::Scalar()); !status.ok()) {
    return status;
  }
  return static_cast<Element>(*elements.begin());
}

// Reinterprets bytes as 8-bit integers.
template <typename Byte>
absl::Span<const Byte> NumbersOf(const std::string& bytes) {
  return {reinterpret_cast<const Byte*>(bytes.data()), bytes.size()};
}

absl::StatusOr<std::vector<int64_t>> ReadUint64s(absl::string_view field, const dm::Tensor& tensor,
                                                 TensorShape shape) {
  for (const uint64_t element : tensor.uint64s().array()) {
    if (element > uint64_t{INT64_MAX}) {
      return absl::InvalidArgumentError(
          absl::StrCat(field, " is ", element, ", allowed: at most ", INT64_MAX));
    }
  }
  return Read<int64_t>(field, tensor, tensor.uint64s().array(), shape);
}

}  // namespace

absl::StatusOr<std::vector<int32_t>> ReadInt32s(absl::string_view field, const dm::Tensor& tensor,
                                                TensorShape shape) {
  if (!tensor.has_int32s()) {
    return WrongType(field, tensor, "INT32");
  }
  return Read<int32_t>(field, tensor, tensor.int32s().array(), shape);
}

absl::StatusOr<std::vector<int64_t>> ReadIntegers(absl::string_view field, const dm::Tensor& tensor,
                                                  TensorShape shape) {
  switch (tensor.payload_case()) {
    case dm::Tensor::kInt8S:
      return Read<int64_t>(field, tensor, NumbersOf<int8_t>(tensor.int8s().array()), shape);
    case dm::Tensor::kInt32S:
      return Read<int64_t>(field, tensor, tensor.int32s().array(), shape);
    case dm::Tensor::kInt64S:
      return Read<int64_t>(field, tensor, tensor.int64s().array(), shape);
    case dm::Tensor::kUint8S:
      return Read<int64_t>(field, tensor, NumbersOf<uint8_t>(tensor.uint8s().array()), shape);
    case dm::Tensor::kUint32S:
      return Read<int64_t>(field, tensor, tensor.uint32s().array(), shape);
    case dm::Tensor::kUint64S:
      return ReadUint64s(field, tensor, shape);
    default:
      return WrongType(field, tensor, "an integer type");
  }
}

absl::StatusOr<std::vector<int32_t>> ReadIntegersAsInt32s(absl::string_view field,
                                                          const dm::Tensor& tensor,
                                                          TensorShape shape) {
  const absl::StatusOr<std::vector<int64_t>> read = ReadIntegers(field, tensor, shape);
  if (!read.ok()) {
    return read.status();
  }
  for (const int64_t value : *read) {
    if (absl::Status status = CheckRange(field, value, INT32_MIN, INT32_MAX); !status.ok()) {
      return status;
    }
  }
  return std::vector<int32_t>(read->begin(), read->end());
}

absl::StatusOr<int64_t> ReadInteger(absl::string_view field, const dm::Tensor& tensor, int64_t min,
                                    int64_t max) {
  const absl::StatusOr<std::vector<int64_t>> read =
      ReadIntegers(field, tensor, TensorShape::Scalar());
  if (!read.ok()) {
    return read.status();
  }
  if (absl::Status status = CheckRange(field, read->front(), min, max); !status.ok()) {
    return status;
  }
  return read->front();
}

absl::StatusOr<bool> ReadBool(absl::string_view field, const dm::Tensor& tensor) {
  if (tensor.has_bools()) {
    return ReadScalar<bool>(field, tensor, tensor.bools().array());
  }
  const absl::StatusOr<int64_t> value = ReadInteger(field, tensor, 0, 1);
  if (!value.ok()) {
    return value.status();
  }
  return *value == 1;
}

absl::StatusOr<double> ReadNumber(absl::string_view field, const dm::Tensor& tensor) {
  absl::StatusOr<double> number;
  if (tensor.has_doubles()) {
    number = ReadScalar<double>(field, tensor, tensor.doubles().array());
  } else if (tensor.has_floats()) {
    number = ReadScalar<double>(field, tensor, tensor.floats().array());
  } else {
    const absl::StatusOr<int64_t> integer = ReadInteger(field, tensor, INT64_MIN, INT64_MAX);
    if (!integer.ok()) {
      return integer.status();
    }
    number = static_cast<double>(*integer);
  }
  if (number.ok() && !std::isfinite(*number)) {
    return absl::InvalidArgumentError(
        absl::StrCat(field, " is ", *number, ", allowed: a finite number"));
  }
  return number;
}

absl::StatusOr<std::string> ReadText(absl::string_view field, const dm::Tensor& tensor) {
  if (!tensor.has_strings()) {
    return WrongType(field, tensor, "STRING");
  }
  return ReadScalar<std::string>(field, tensor, tensor.strings().array());
}

absl::StatusOr<std::vector<std::string>> ReadTexts(absl::string_view field,
                                                   const dm::Tensor& tensor) {
  if (!tensor.has_strings()) {
    return WrongType(field, tensor, "STRING");
  }
  const TensorShape shape =
      tensor.shape_size() == 0 ? TensorShape::Scalar() : TensorShape::List(TensorShape::kAnyLength);
  return Read<std::string>(field, tensor, tensor.strings().array(), shape);
}

absl::StatusOr<absl::string_view> ReadBytes(absl::string_view field, const dm::Tensor& tensor) {
  if (!tensor.has_uint8s()) {
    return WrongType(field, tensor, "UINT8");
  }
  const std::string& bytes = tensor.uint8s().array();
  if (absl::Status status = CheckShape(field, tensor, static_cast<int64_t>(bytes.size()),
                                       TensorShape::List(TensorShape::kAnyLength));
      !status.ok()) {
    return status;
  }
  return bytes;
}

std::string Truncated(absl::string_view text) {
  if (text.size() <= kTextBytesMax) {
    return std::string(text);
  }
  // UTF-8 continuation bytes are 10xxxxxx; the cut is before a character's first byte.
  size_t size = kTextBytesMax;
  while (size > 0 && (static_cast<uint8_t>(text[size]) & 0xC0U) == 0x80U) {
    --size;
  }
  return absl::StrCat(text.substr(0, size), "...");
}

}  // namespace procgen
