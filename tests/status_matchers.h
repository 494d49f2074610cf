#ifndef TESTS_STATUS_MATCHERS_H_
#define TESTS_STATUS_MATCHERS_H_

#include <string>

#include "absl/status/status.h"
#include "gmock/gmock.h"

namespace procgen {

// Of the engine's statuses, too, which convert.
inline absl::Status StatusOf(const absl::Status& status) { return status; }
template <typename Result>
requires requires(const Result& result) { result.status(); }
absl::Status StatusOf(const Result& result) { return result.status(); }

// Matches a Status or StatusOr that is OK.
MATCHER(IsOk, "is OK") {
  *result_listener << StatusOf(arg).ToString();
  return StatusOf(arg).ok();
}

// Matches a StatusOr with a value that matches.
MATCHER_P(IsOkAndHolds, value, "is OK and holds " + testing::PrintToString(value)) {
  *result_listener << StatusOf(arg).ToString();
  return arg.ok() && *arg == value;
}

// Matches a status with this code and a message that matches `message`.
MATCHER_P2(StatusIs, code, message,
           "is " + absl::StatusCodeToString(code) + " with a message that " +
               testing::DescribeMatcher<std::string>(message)) {
  *result_listener << StatusOf(arg).ToString();
  const absl::Status status = StatusOf(arg);
  return status.code() == code && testing::Value(std::string(status.message()), message);
}

}  // namespace procgen

#endif  // TESTS_STATUS_MATCHERS_H_
