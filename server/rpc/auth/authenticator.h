#ifndef SERVER_RPC_AUTH_AUTHENTICATOR_H_
#define SERVER_RPC_AUTH_AUTHENTICATOR_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "server/rpc/auth/token_file.h"

namespace procgen {

// Says who calls.
//
// Who calls is told by its token, where there are tokens; else by its certificate, where clients
// must show one: the first URI of its alternative names, or if it has none its common name. Else
// nobody is asked, and all are the owner "".
// Threads: any method from any thread.
class Authenticator {
 public:
  // `tokens`: null, there are none.
  Authenticator(std::shared_ptr<TokenFile> tokens, bool certificates_tell);

  // Errors: UNAUTHENTICATED its token is missing or nobody's, or its certificate has no name (the
  // message says what is expected and repeats nothing that was given).
  absl::StatusOr<std::string> OwnerOf(const grpc::ServerContextBase& context) const;

 private:
  absl::StatusOr<std::string> OwnerByToken(const grpc::ServerContextBase& context) const;

  const std::shared_ptr<TokenFile> tokens_;
  const bool certificates_tell_;
};

}  // namespace procgen

#endif  // SERVER_RPC_AUTH_AUTHENTICATOR_H_
