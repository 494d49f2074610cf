#ifndef SERVER_RPC_TOKEN_FILE_H_
#define SERVER_RPC_TOKEN_FILE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "server/rpc/watched_file.h"

namespace procgen {

// Lengths of a token and of an owner's name, in characters.
inline constexpr size_t kTokenLengthMin = 16;
inline constexpr size_t kTokenLengthMax = 512;
inline constexpr size_t kOwnerLengthMax = 128;

// A token's SHA-256 and whose it is. Tokens themselves are not kept.
struct TokenDigest {
  std::array<uint8_t, 32> sha256;
  std::string owner;
};

// Reads lines "OWNER TOKEN"; what follows a '#', and empty lines, mean nothing. An owner may have
// several tokens, so that one can be replaced without a gap.
// Errors: INVALID_ARGUMENT; the message names the line, never what is in it.
absl::StatusOr<std::vector<TokenDigest>> ParseTokens(absl::string_view text);

// The file that says who may call with which token. Read again by whoever asks first after it has
// changed; one that is broken then is told in the log, and what was read before stays in force.
// Threads: any method from any thread.
class TokenFile {
 public:
  // Errors: the file cannot be read, or those of ParseTokens; the message names the file.
  static absl::StatusOr<std::shared_ptr<TokenFile>> Open(const std::string& path);

  // Whose token it is; none: nobody's. Takes as long for each token of the file as for another.
  std::optional<std::string> OwnerOf(absl::string_view token);

 private:
  explicit TokenFile(const std::string& path) : file_(path) {}
  absl::Status Read() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  absl::Mutex mutex_;
  WatchedFile file_ ABSL_GUARDED_BY(mutex_);
  std::vector<TokenDigest> digests_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_RPC_TOKEN_FILE_H_
