#ifndef SERVER_WIRE_ENUM_VALUE_H_
#define SERVER_WIRE_ENUM_VALUE_H_

#include <cstddef>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "google/protobuf/generated_enum_reflection.h"
#include "proto/engine_enums.h"

namespace procgen {

// Returns the name of an API enum's value, or its number if it is unknown.
template <typename Enum>
std::string EnumText(Enum value) {
  const auto* descriptor = google::protobuf::GetEnumDescriptor<Enum>();
  const auto* named = descriptor->FindValueByNumber(static_cast<int>(value));
  return named == nullptr ? absl::StrCat("number ", static_cast<int>(value)) : named->name();
}

// Returns an INVALID_ARGUMENT error with the value of `field` and the allowed ones.
template <typename Enum>
absl::Status NoSuchValue(absl::string_view field, Enum value) {
  std::string allowed;
  const auto* descriptor = google::protobuf::GetEnumDescriptor<Enum>();
  for (int i = 1; i < descriptor->value_count(); ++i) {
    absl::StrAppend(&allowed, i == 1 ? "" : ", ", descriptor->value(i)->name());
  }
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", EnumText(value), ", allowed: ", allowed));
}

// Returns the engine's value. Errors: INVALID_ARGUMENT there is none.
template <typename Enum, typename Value, size_t kCount>
absl::StatusOr<Value> ValueOf(EnumTable<Enum, Value, kCount>& table, absl::string_view field,
                              Enum given) {
  for (const auto& [known, value] : table) {
    if (given == known || given == Enum()) {
      return value;
    }
  }
  return NoSuchValue(field, given);
}

}  // namespace procgen

#endif  // SERVER_WIRE_ENUM_VALUE_H_
