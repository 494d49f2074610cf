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

// The messages of pages and server; README.md, "Messages", tells their form.

inline constexpr size_t kMessageBytesMax = 4 << 20;  // of one that a page sends
inline constexpr size_t kHeaderBytesMax = 64 << 10;  // of its JSON
inline constexpr size_t kPartCountMax = 4;           // of its parts
inline constexpr int64_t kIdMax = int64_t{1} << 53;  // that a page counts exactly to

// Bytes that go with the JSON of a binary message.
struct Part {
  std::string name;
  std::string format;  // "rgb", "png" or "trace"
  std::string bytes;
  Json more = Json::object();  // further members of its entry, such as "width"
};

// What a page asks for.
struct Request {  // NOLINT(bugprone-exception-escape): JSON that is moved throws nothing
  int64_t id = 0;
  std::string method;
  Json members;  // an object: all others
  std::vector<Part> parts;
};

// What it is answered: JSON, and binary where there are parts.
struct Answer {
  Json result = Json::object();
  std::vector<Part> parts;
};

// A message as it travels.
struct WireMessage {
  std::string bytes;
  bool is_binary = false;
};

// Errors: INVALID_ARGUMENT it is none, so that there is no id to answer to.
absl::StatusOr<Request> ParseRequest(absl::string_view bytes, bool is_binary);

WireMessage EncodeAnswer(int64_t id, const absl::StatusOr<Answer>& answer);
// An event: `header` has the member "event".
WireMessage EncodeEvent(Json header, const std::vector<Part>& parts = {});
// The event that something ended by itself, and why.
Json EndedEvent(const char* event, const absl::Status& status);

// The members of a request, checked one by one; the first that is wrong decides what CheckAll says.
// After a wrong one, a value that would be right is returned.
class RequestParams {
 public:
  // `members` must outlive this.
  explicit RequestParams(const Json& members) : members_(members) {}

  bool Has(const std::string& name);
  // In [min, max].
  int64_t Integer(const std::string& name, int64_t min, int64_t max);
  int32_t Integer32(const std::string& name, int32_t min, int32_t max) {
    return static_cast<int32_t>(Integer(name, min, max));
  }
  // The same where it may be left out.
  int32_t Integer32Or(const std::string& name, int32_t otherwise, int32_t min, int32_t max) {
    return Has(name) ? Integer32(name, min, max) : otherwise;
  }
  double NumberOr(const std::string& name, double otherwise, double min, double max);
  // Of at most kTextLengthMax bytes.
  std::string Text(const std::string& name);
  // One of `allowed`.
  std::string Choice(const std::string& name, const std::vector<std::string>& allowed);
  // A list of 1 to `count_max` integers in [0, max].
  std::vector<int32_t> Integers(const std::string& name, size_t count_max, int32_t max);
  // An object, or an empty one where it is left out.
  const Json& ObjectOr(const std::string& name);

  // Says that something is wrong.
  void Refuse(absl::string_view message);
  // OK: all that were asked for are right, and there are no others. Errors: INVALID_ARGUMENT.
  absl::Status CheckAll();

 private:
  // Null: it is missing, which is told.
  const Json* Find(const std::string& name);

  const Json& members_;
  std::vector<std::string> known_;
  absl::Status status_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_JSON_MESSAGE_H_
