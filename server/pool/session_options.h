#ifndef SERVER_POOL_SESSION_OPTIONS_H_
#define SERVER_POOL_SESSION_OPTIONS_H_

#include <cstddef>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "server/encoding/encoding.h"

namespace procgen {

// Limits of the names of a pool for people.
inline constexpr size_t kDisplayNameBytesMax = 128;
inline constexpr size_t kLabelCountMax = 16;
inline constexpr size_t kLabelKeyBytesMax = 64;
inline constexpr size_t kLabelValueBytesMax = 128;

// What a caller sets of a pool besides its environments.
struct SessionOptions {
  Encoding encoding = Encoding::kRaw;  // how its observations are sent
  // For people; the server does not use them.
  std::string display_name;
  std::map<std::string, std::string> labels;
};

// Checks name and labels, which are UTF-8. Errors: INVALID_ARGUMENT; the message gives the value
// and the allowed values.
absl::Status CheckSessionOptions(const SessionOptions& options);

}  // namespace procgen

#endif  // SERVER_POOL_SESSION_OPTIONS_H_
