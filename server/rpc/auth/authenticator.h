#ifndef SERVER_RPC_AUTH_AUTHENTICATOR_H_
#define SERVER_RPC_AUTH_AUTHENTICATOR_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "server/rpc/auth/token_file.h"

namespace procgen {

// Determines the owner of a call.
//
// With a token file, the token determines the owner. Otherwise, if clients must present a
// certificate, the owner is the first URI of its alternative names, or else its common name.
// Without both, all callers are the owner "". Threads: any method from any thread.
class Authenticator {
 public:
  // `tokens`: null if there is no token file. `use_certificates`: clients must
  // present a certificate.
  Authenticator(std::shared_ptr<TokenFile> tokens, bool use_certificates);

  // Errors: UNAUTHENTICATED the token is missing or unknown, or the certificate has no name; the
  // message contains the expected form and nothing that was given.
  absl::StatusOr<std::string> OwnerOf(const grpc::ServerContextBase& context) const;

 private:
  absl::StatusOr<std::string> OwnerByToken(const grpc::ServerContextBase& context) const;

  const std::shared_ptr<TokenFile> tokens_;
  const bool use_certificates_;
};

}  // namespace procgen

#endif  // SERVER_RPC_AUTH_AUTHENTICATOR_H_
