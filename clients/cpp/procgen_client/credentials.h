#ifndef PROCGEN_CLIENT_CREDENTIALS_H_
#define PROCGEN_CLIENT_CREDENTIALS_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "grpcpp/client_context.h"
#include "grpcpp/security/credentials.h"

namespace procgen_client {

// TLS certificates and token of a client. PEM fields contain the text, not paths.
struct Credentials {
  // CA certificates of the server, PEM. Not empty: the client uses TLS; empty: plain text.
  std::string ca;
  // Client certificate and key, PEM, for servers that require one. Both or none; requires `ca`.
  std::string certificate;
  std::string key;
  // Token for servers that require one. Without TLS it is sent only to this machine (loopback, unix
  // sockets), unless `token_in_plain_text`.
  std::string token;
  bool token_in_plain_text = false;

  // Reads the environment variables PROCGEN_SERVER_CA, PROCGEN_SERVER_CERTIFICATE and
  // PROCGEN_SERVER_KEY, paths of PEM files, and PROCGEN_SERVER_TOKEN, the token. Each is optional.
  // Errors: NOT_FOUND a file is empty or cannot be read.
  static absl::StatusOr<Credentials> FromEnvironment();
};

// Whether the address is loopback or a unix socket, where plain text is safe.
bool IsThisMachine(absl::string_view address);

// Checks credentials for a connection to `address`; does not start gRPC, which reads its
// environment variables then. Errors: INVALID_ARGUMENT a certificate without its key or without
// `ca`, a token with white space, or one that would be sent to another machine in plain text.
absl::Status CheckCredentials(const Credentials& credentials, const std::string& address);

// Converts credentials to gRPC's. Errors: those of CheckCredentials.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> ChannelCredentialsOf(
    const Credentials& credentials, const std::string& address);

// Adds `token` to the metadata of a call, unless it is empty.
void ShowToken(const std::string& token, grpc::ClientContext* context);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_CREDENTIALS_H_
