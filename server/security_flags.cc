#include "server/security_flags.h"

#include <string>

#include "absl/flags/flag.h"

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

}  // namespace procgen
