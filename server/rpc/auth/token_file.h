#ifndef SERVER_RPC_AUTH_TOKEN_FILE_H_
#define SERVER_RPC_AUTH_TOKEN_FILE_H_

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
#include "server/net/watched_file.h"

namespace procgen {

// Lengths of a token and of an owner's name, in characters.
inline constexpr size_t kTokenLengthMin = 16;
inline constexpr size_t kTokenLengthMax = 512;
inline constexpr size_t kOwnerLengthMax = 128;

// A token's SHA-256 and its owner. Tokens themselves are not kept.
struct TokenDigest {
  std::array<uint8_t, 32> sha256;
  std::string owner;
};

// Parses lines "OWNER TOKEN". Ignores empty lines and text after '#'. An owner may have several
// tokens, which allows rotation.
// Errors: INVALID_ARGUMENT; the message has the line number, never its contents.
absl::StatusOr<std::vector<TokenDigest>> ParseTokens(absl::string_view text);

// The file of tokens and their owners. The first look-up after a change reads it again; if it is
// invalid then, a warning is logged and the previous tokens stay valid.
// Threads: any method from any thread.
class TokenFile {
 public:
  // Errors: the file cannot be read, or those of ParseTokens; the message names the file.
  static absl::StatusOr<std::shared_ptr<TokenFile>> Open(const std::string& path);

  // Returns the owner of a token, or nullopt. Takes the same time for every token of the file.
  std::optional<std::string> OwnerOf(absl::string_view token);

 private:
  // The file as it was read, and its tokens. Immutable: callers read it without a lock.
  struct Snapshot {
    WatchedFile file;
    std::vector<TokenDigest> digests;
  };

  explicit TokenFile(const std::string& path)
      : snapshot_(std::make_shared<const Snapshot>(Snapshot{WatchedFile(path), {}})) {}
  // Reads the file. On error the tokens stay, and the file is not read again until it changes.
  absl::Status Read() ABSL_EXCLUSIVE_LOCKS_REQUIRED(reading_);
  // Reads the file if it has changed.
  void ReadAgain() ABSL_LOCKS_EXCLUDED(reading_);
  std::shared_ptr<const Snapshot> Current() const ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Mutex reading_;        // held while the file is read; before mutex_
  mutable absl::Mutex mutex_;  // held while the pointer is copied
  std::shared_ptr<const Snapshot> snapshot_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_RPC_AUTH_TOKEN_FILE_H_
