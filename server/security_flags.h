#ifndef SERVER_SECURITY_FLAGS_H_
#define SERVER_SECURITY_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Puts into `config` what the flags say of who may call, and how much each caller may have. The
// limits of the whole server must be in it already.
void ReadSecurityFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_SECURITY_FLAGS_H_
