#ifndef ENVCORE_STATUS_STATUS_H_
#define ENVCORE_STATUS_STATUS_H_

#include <optional>
#include <ostream>
#include <string>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen {

// A result without a value: a canonical code, and a message that says what was given and what is
// allowed. It converts to absl::Status, whose interface it has as far as the engine needs it.
//
// The engine does not use absl::Status itself: that links Abseil's Cord, Mutex and time zones,
// which Debian builds for programs only, and the engine is also a shared library (clients/c).
class [[nodiscard]] Status {
 public:
  Status() = default;  // OK
  Status(absl::StatusCode code, absl::string_view message) : code_(code), message_(message) {}

  bool ok() const { return code_ == absl::StatusCode::kOk; }
  absl::StatusCode code() const { return code_; }
  absl::string_view message() const { return message_; }
  void IgnoreError() const {}

  operator absl::Status() const { return absl::Status(code_, message_); }  // NOLINT: implicit
  friend std::ostream& operator<<(std::ostream& out, const Status& status) {
    return out << absl::Status(status);
  }

 private:
  absl::StatusCode code_ = absl::StatusCode::kOk;
  std::string message_;
};

// A value, or the status that says why there is none. Converts to absl::StatusOr.
template <typename Value>
class [[nodiscard]] StatusOr {
 public:
  // As absl::StatusOr. What is convertible to Value is not a StatusOr.
  // NOLINTBEGIN(google-explicit-constructor,bugprone-forwarding-reference-overload)
  // REQUIRES: not OK.
  StatusOr(Status status) : status_(std::move(status)) {}
  template <typename Given>
  requires std::is_convertible_v<Given&&, Value> StatusOr(Given&& value)
      : value_(std::forward<Given>(value)) {}
  operator absl::StatusOr<Value>() && {
    return ok() ? absl::StatusOr<Value>(*std::move(value_)) : absl::StatusOr<Value>(status_);
  }
  // NOLINTEND(google-explicit-constructor,bugprone-forwarding-reference-overload)

  bool ok() const { return value_.has_value(); }
  const Status& status() const { return status_; }

  // REQUIRES: ok().
  Value& operator*() & { return *value_; }
  const Value& operator*() const& { return *value_; }
  Value&& operator*() && { return *std::move(value_); }
  Value* operator->() { return &*value_; }
  const Value* operator->() const { return &*value_; }
  // Like *, but a missing value ends the program.
  Value& value() & { return value_.value(); }
  const Value& value() const& { return value_.value(); }
  Value&& value() && { return std::move(value_).value(); }

 private:
  Status status_;
  std::optional<Value> value_;
};

inline Status OkStatus() { return {}; }
inline Status InvalidArgumentError(absl::string_view message) {
  return {absl::StatusCode::kInvalidArgument, message};
}
inline Status NotFoundError(absl::string_view message) {
  return {absl::StatusCode::kNotFound, message};
}
inline Status ResourceExhaustedError(absl::string_view message) {
  return {absl::StatusCode::kResourceExhausted, message};
}
inline Status FailedPreconditionError(absl::string_view message) {
  return {absl::StatusCode::kFailedPrecondition, message};
}
inline Status AbortedError(absl::string_view message) {
  return {absl::StatusCode::kAborted, message};
}
inline Status DeadlineExceededError(absl::string_view message) {
  return {absl::StatusCode::kDeadlineExceeded, message};
}
inline Status InternalError(absl::string_view message) {
  return {absl::StatusCode::kInternal, message};
}
inline Status DataLossError(absl::string_view message) {
  return {absl::StatusCode::kDataLoss, message};
}

}  // namespace procgen

#endif  // ENVCORE_STATUS_STATUS_H_
