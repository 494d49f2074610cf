#include "server/rpc/auth/token_file.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "openssl/crypto.h"
#include "openssl/sha.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

std::array<uint8_t, 32> DigestOf(absl::string_view token) {
  std::array<uint8_t, 32> digest = {};
  static_assert(sizeof(digest) == SHA256_DIGEST_LENGTH);
  SHA256(reinterpret_cast<const uint8_t*>(token.data()), token.size(), digest.data());
  return digest;
}

// Whether `letter` is allowed in a bearer token (RFC 6750).
bool IsTokenLetter(char letter) {
  return absl::ascii_isalnum(static_cast<unsigned char>(letter)) ||
         absl::StrContains("-._~+/=", letter);
}

absl::Status CheckLine(const std::vector<absl::string_view>& words) {
  if (words.size() != 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("has ", words.size(), " words, allowed: 'OWNER TOKEN'"));
  }
  if (words[0].size() > kOwnerLengthMax ||
      !std::all_of(words[0].begin(), words[0].end(),
                   [](unsigned char letter) { return absl::ascii_isgraph(letter); })) {
    return absl::InvalidArgumentError(absl::StrCat("has an owner of ", words[0].size(),
                                                   " characters, allowed: 1 to ", kOwnerLengthMax,
                                                   " printable ASCII characters"));
  }
  if (words[1].size() < kTokenLengthMin || words[1].size() > kTokenLengthMax ||
      !std::all_of(words[1].begin(), words[1].end(), IsTokenLetter)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "has a token of ", words[1].size(), " characters, allowed: ", kTokenLengthMin, " to ",
        kTokenLengthMax, " of a-z, A-Z, 0-9 and -._~+/=; 'openssl rand -hex 32' generates one"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<TokenDigest>> ParseTokens(absl::string_view text) {
  std::vector<TokenDigest> digests;
  std::map<std::array<uint8_t, 32>, int> seen;  // line number by digest
  int line_number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++line_number;
    line = line.substr(0, line.find('#'));
    const std::vector<absl::string_view> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (words.empty()) {
      continue;
    }
    if (absl::Status status = CheckLine(words); !status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat("line ", line_number, " ", status.message()));
    }
    const TokenDigest digest = {DigestOf(words[1]), std::string(words[0])};
    const auto [first, is_new] = seen.emplace(digest.sha256, line_number);
    if (!is_new) {
      return absl::InvalidArgumentError(absl::StrCat(
          "line ", line_number, " has the token of line ", first->second, ", allowed: each once"));
    }
    digests.push_back(digest);
  }
  if (digests.empty()) {
    return absl::InvalidArgumentError("has no token, allowed: at least one line 'OWNER TOKEN'");
  }
  return digests;
}

absl::StatusOr<std::shared_ptr<TokenFile>> TokenFile::Open(const std::string& path) {
  std::shared_ptr<TokenFile> tokens(new TokenFile(path));
  absl::MutexLock lock(&tokens->reading_);
  if (absl::Status status = tokens->Read(); !status.ok()) {
    return status;
  }
  return tokens;
}

absl::Status TokenFile::Read() {
  auto next = std::make_shared<Snapshot>(*Current());
  const absl::StatusOr<std::string> text = next->file.Read();
  absl::Status status = text.status();
  if (text.ok()) {
    absl::StatusOr<std::vector<TokenDigest>> digests = ParseTokens(*text);
    if (digests.ok()) {
      next->digests = *std::move(digests);
    } else {
      status = absl::InvalidArgumentError(
          absl::StrCat(next->file.path(), ": ", digests.status().message()));
    }
  }
  if (status.ok() && next->file.is_world_readable()) {
    LogEvent(LogLevel::kWarning, "token_file_world_readable",
             {{"file", next->file.path()}, {"message", "all users can read it; chmod o-r"}});
  }
  absl::MutexLock lock(&mutex_);
  snapshot_ = std::move(next);
  return status;
}

std::shared_ptr<const TokenFile::Snapshot> TokenFile::Current() const {
  absl::MutexLock lock(&mutex_);
  return snapshot_;
}

void TokenFile::ReadAgain() {
  absl::MutexLock lock(&reading_);
  if (!Current()->file.HasChanged()) {
    return;  // another call has read it meanwhile
  }
  const absl::Status status = Read();
  const std::shared_ptr<const Snapshot> current = Current();
  LogEvent(status.ok() ? LogLevel::kInfo : LogLevel::kWarning,
           status.ok() ? "tokens_reloaded" : "tokens_reload_failed",
           {{"file", current->file.path()},
            {"tokens_in_force", absl::StrCat(current->digests.size())},
            {"message", std::string(status.message())}});
}

std::optional<std::string> TokenFile::OwnerOf(absl::string_view token) {
  const std::array<uint8_t, 32> given = DigestOf(token);
  std::shared_ptr<const Snapshot> current = Current();
  if (current->file.HasChanged()) {
    ReadAgain();
    current = Current();
  }
  const TokenDigest* found = nullptr;
  for (const TokenDigest& digest : current->digests) {
    if (CRYPTO_memcmp(digest.sha256.data(), given.data(), given.size()) == 0) {
      found = &digest;
    }
  }
  return found == nullptr ? std::nullopt : std::optional(found->owner);
}

}  // namespace procgen
