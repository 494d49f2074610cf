#ifndef PROCGEN_CLIENT_CREDENTIALS_H_
#define PROCGEN_CLIENT_CREDENTIALS_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "grpcpp/client_context.h"
#include "grpcpp/security/credentials.h"

namespace procgen_client {

// How a client knows its server, and what it shows to it. All PEM is text, not paths.
struct Credentials {
  // Certificates that vouch for the server. Not empty: TLS is spoken; empty: plain text.
  std::string ca;
  // The client's own certificate and its key, for servers that ask for one. Both or none; with
  // `ca`.
  std::string certificate;
  std::string key;
  // Bears out who calls, for servers with tokens. Without TLS it is sent to this machine only
  // (loopback, unix sockets), unless `token_in_plain_text`.
  std::string token;
  bool token_in_plain_text = false;

  // What these environment variables say, each of which may be missing: PROCGEN_SERVER_CA,
  // PROCGEN_SERVER_CERTIFICATE and PROCGEN_SERVER_KEY, paths of PEM files; PROCGEN_SERVER_TOKEN,
  // the token. Errors: NOT_FOUND a file that cannot be read.
  static absl::StatusOr<Credentials> FromEnvironment();
};

// Whether the address is loopback or a unix socket: nobody else can listen on the way to it.
bool IsThisMachine(absl::string_view address);

// As gRPC takes them, for a connection to `address`. Errors: INVALID_ARGUMENT a certificate without
// its key or without `ca`, or a token that would be sent to another machine in plain text.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> ChannelCredentialsOf(
    const Credentials& credentials, const std::string& address);

// Has a call bear `token`, if it is not empty.
void ShowToken(const std::string& token, grpc::ClientContext* context);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_CREDENTIALS_H_
