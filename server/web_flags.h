#ifndef SERVER_WEB_FLAGS_H_
#define SERVER_WEB_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Puts into `config` what the flags say of the pages that the server serves.
void ReadWebFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_WEB_FLAGS_H_
