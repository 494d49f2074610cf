#ifndef SERVER_WEB_JSON_MESSAGE_H_
#define SERVER_WEB_JSON_MESSAGE_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nlohmann/json.hpp"

namespace procgen::web {

using Json = nlohmann::json;

// Messages between pages and server; README.md defines their form.

inline constexpr size_t kMessageBytesMax = 4 << 20;  // of one message of a page
inline constexpr size_t kHeaderBytesMax = 64 << 10;  // of the JSON of a message
inline constexpr size_t kPartCountMax = 4;           // parts of a message
inline constexpr int64_t kIdMax = int64_t{1} << 53;  // largest integer that is exact in JavaScript

// A part of a binary message.
struct Part {
  std::string name;
  std::string format;  // "rgb", "deflate", "png" or "trace"
  std::string bytes;
  Json more = Json::object();  // further members of its entry in `parts`, such as "width"
};

// A request of a page.
struct Request {  // NOLINT(bugprone-exception-escape): JSON that is moved throws nothing
  int64_t id = 0;
  std::string method;
  Json members;  // an object with all other members
  std::vector<Part> parts;
};

// The answer to a request; sent as a binary message if it has parts.
struct Answer {
  Json result = Json::object();
  std::vector<Part> parts;
};

// An encoded message.
struct WireMessage {
  std::string bytes;
  bool is_binary = false;
};

// Errors: INVALID_ARGUMENT the message is not a request, so there is no id to answer.
absl::StatusOr<Request> ParseRequest(absl::string_view bytes, bool is_binary);

WireMessage EncodeAnswer(int64_t id, const absl::StatusOr<Answer>& answer);
// Encodes an event; `header` has the member "event".
WireMessage EncodeEvent(Json header, const std::vector<Part>& parts = {});
// An event that reports the end of something and the reason.
Json EndedEvent(const char* event, const absl::Status& status);

// Reads and validates the members of a request. CheckAll returns the first error. For an invalid
// member, the methods return some valid value.
class RequestParams {
 public:
  // `members` must outlive this.
  explicit RequestParams(const Json& members) : members_(members) {}

  bool Has(const std::string& name);
  // An integer in [min, max].
  int64_t Integer(const std::string& name, int64_t min, int64_t max);
  int32_t Integer32(const std::string& name, int32_t min, int32_t max) {
    return static_cast<int32_t>(Integer(name, min, max));
  }
  // The same for an optional member.
  int32_t Integer32Or(const std::string& name, int32_t otherwise, int32_t min, int32_t max) {
    return Has(name) ? Integer32(name, min, max) : otherwise;
  }
  double NumberOr(const std::string& name, double otherwise, double min, double max);
  bool BooleanOr(const std::string& name, bool otherwise);
  // A text of at most kTextLengthMax bytes.
  std::string Text(const std::string& name);
  // One of `allowed`.
  std::string Choice(const std::string& name, const std::vector<std::string>& allowed);
  // A list of 1 to `count_max` integers in [0, max].
  std::vector<int32_t> Integers(const std::string& name, size_t count_max, int32_t max);
  // An object; empty if the member is missing.
  const Json& ObjectOr(const std::string& name);

  // Reports an error.
  void Refuse(absl::string_view message);
  // Returns OK if all members that were read are valid and there are no others. Errors:
  // INVALID_ARGUMENT.
  absl::Status CheckAll();

 private:
  // Returns null and reports an error if the member is missing.
  const Json* Find(const std::string& name);

  const Json& members_;
  std::vector<std::string> known_;
  absl::Status status_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_JSON_MESSAGE_H_
