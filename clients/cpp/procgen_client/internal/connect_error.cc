#include "procgen_client/internal/connect_error.h"

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/security/tls_credentials_options.h"

namespace procgen_client {
namespace {

constexpr absl::Duration kProbeTimeout = absl::Milliseconds(500);

// Whether the server accepts a connection with TLS. Presents nothing and verifies nothing.
bool AcceptsTls(const std::string& address) {
  grpc::experimental::TlsChannelCredentialsOptions options;
  options.set_verify_server_certs(false);
  options.set_check_call_host(false);
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto channel =
      grpc::CreateCustomChannel(address, grpc::experimental::TlsCredentials(options), arguments);
  return channel->WaitForConnected(absl::ToChronoTime(absl::Now() + kProbeTimeout));
}

// Whether the peer ended the connection, as servers do that expect something else.
bool IsClosedByPeer(absl::string_view reason) {
  return absl::StrContains(reason, "Socket closed") ||
         absl::StrContains(reason, "Connection reset by peer") ||
         absl::StrContains(reason, "handshaker shutdown");
}

}  // namespace

std::string ExplainConnectError(const std::string& address, absl::string_view reason,
                                bool uses_tls) {
  std::string explanation;
  if (!uses_tls) {
    if (IsClosedByPeer(reason) && AcceptsTls(address)) {
      explanation =
          "the server requires TLS: give its CA certificates (the variable PROCGEN_SERVER_CA is "
          "the path of their PEM file)";
    }
  } else if (absl::StrContains(reason, "wrong version number")) {
    explanation =
        "the server does not use TLS: give no CA certificates (unset PROCGEN_SERVER_CA), or start "
        "it with --tls_certificate and --tls_key";
  } else if (absl::StrContains(reason, "certificate verify failed")) {
    explanation =
        "the server's certificate is not signed by the given CA certificates (PROCGEN_SERVER_CA), "
        "or has expired: give those of the authority that signed it";
  } else if (absl::StrContains(reason, "is not in peer certificate")) {
    explanation =
        "the server's certificate is for other names: connect by a name or an address that is in "
        "it";
  }
  return explanation.empty() ? "" : absl::StrCat(explanation, " (", reason, ")");
}

absl::string_view LikelyCause(absl::string_view reason, bool uses_tls) {
  if (!IsClosedByPeer(reason)) {
    return "";
  }
  return uses_tls ? "; the server may require a client certificate (PROCGEN_SERVER_CERTIFICATE, "
                    "PROCGEN_SERVER_KEY)"
                  : "; the server may require TLS (PROCGEN_SERVER_CA) and a client certificate";
}

}  // namespace procgen_client
