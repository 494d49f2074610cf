#ifndef SERVER_SECURITY_FLAGS_H_
#define SERVER_SECURITY_FLAGS_H_

#include <string>

#include "absl/status/statusor.h"
#include "server/config.h"

namespace procgen {

// Reads the flags of access control and of the owners' quotas into `config`. REQUIRES: the limits
// of the whole server are set, which are the defaults of the quotas.
void ReadSecurityFlags(Config* config);

// Whether --make_credentials is given: the program makes files and exits.
bool MakesCredentials();

// MakeCredentials with the flags; `address`: the server's, whose port is printed.
absl::StatusOr<std::string> MakeCredentialsOfFlags(const std::string& address);

}  // namespace procgen

#endif  // SERVER_SECURITY_FLAGS_H_
