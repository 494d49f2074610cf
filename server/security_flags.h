#ifndef SERVER_SECURITY_FLAGS_H_
#define SERVER_SECURITY_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Reads the flags of access control into `config`.
void ReadSecurityFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_SECURITY_FLAGS_H_
