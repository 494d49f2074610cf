#ifndef SERVER_SECURITY_FLAGS_H_
#define SERVER_SECURITY_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Reads the flags of access control and of the owners' quotas into `config`. REQUIRES: the limits
// of the whole server are set, which are the defaults of the quotas.
void ReadSecurityFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_SECURITY_FLAGS_H_
