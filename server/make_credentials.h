#ifndef SERVER_MAKE_CREDENTIALS_H_
#define SERVER_MAKE_CREDENTIALS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace procgen {

struct CredentialsOptions {
  std::string dir;                 // created if it does not exist
  std::vector<std::string> hosts;  // DNS names and IP addresses by which learners connect
  std::string owner;               // of the token
  uint16_t port = 0;               // of the printed address
};

// Makes files in `dir` that a server needs for learners on other machines: the certificate and key
// of a new authority (ca.pem, ca.key), those of a server that it signs for `hosts` (server.pem,
// server.key), and a file with a token of `owner` (tokens). Only this user can read the keys and
// the tokens. Returns text for people: the server's flags and a learner's environment variables.
// Errors: INVALID_ARGUMENT a host or the owner is invalid; ALREADY_EXISTS one of the files exists,
// and nothing was written; UNKNOWN a file cannot be written; INTERNAL OpenSSL failed.
absl::StatusOr<std::string> MakeCredentials(const CredentialsOptions& options);

}  // namespace procgen

#endif  // SERVER_MAKE_CREDENTIALS_H_
