#include "server/security_flags.h"

#include <cstdint>
#include <string>
#include <vector>

#include "absl/flags/flag.h"
#include "server/duration_flag.h"
#include "server/make_credentials.h"
#include "server/net/address.h"

ABSL_FLAG(std::string, tls_certificate, "",
          "PEM file of the server's certificate chain, its own first; read again when it changes. "
          "Empty: plain text");
ABSL_FLAG(std::string, tls_key, "", "PEM file of the key of --tls_certificate");
ABSL_FLAG(std::string, tls_client_ca, "",
          "PEM file of authorities; clients must present a certificate signed by one of them. "
          "Empty: clients need no certificate");
ABSL_FLAG(std::string, tokens, "",
          "file of lines 'OWNER TOKEN'; every call must carry one; read again when it changes. "
          "Empty: calls need no token");
ABSL_FLAG(std::string, make_credentials, "",
          "folder in which to make a certificate authority, a server certificate for --for and a "
          "token of --owner; prints the flags and the environment that use them, and exits");
ABSL_FLAG(std::vector<std::string>, for, {},
          "with --make_credentials: names and addresses by which learners connect, "
          "comma-separated");
ABSL_FLAG(std::string, owner, "learner", "with --make_credentials: owner of the token");
ABSL_FLAG(
    bool, allow_insecure, false,
    "allow listening beyond loopback without TLS or without authentication, also for metrics and "
    "pages");

namespace procgen {

void ReadSecurityFlags(Config* config) {
  config->tls.certificate = absl::GetFlag(FLAGS_tls_certificate);
  config->tls.key = absl::GetFlag(FLAGS_tls_key);
  config->tls.client_ca = absl::GetFlag(FLAGS_tls_client_ca);
  config->tokens = absl::GetFlag(FLAGS_tokens);
  config->allow_insecure = absl::GetFlag(FLAGS_allow_insecure);
}

absl::StatusOr<std::string> MakeCredentialsOfFlags(const std::string& address) {
  const absl::StatusOr<Address> parsed = ParseAddress(address);
  return MakeCredentials({.dir = absl::GetFlag(FLAGS_make_credentials),
                          .hosts = absl::GetFlag(FLAGS_for),
                          .owner = absl::GetFlag(FLAGS_owner),
                          .port = parsed.ok() ? parsed->port : uint16_t{0}});
}

bool MakesCredentials() { return !absl::GetFlag(FLAGS_make_credentials).empty(); }

}  // namespace procgen
