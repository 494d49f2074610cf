#ifndef SERVER_WEB_FLAGS_H_
#define SERVER_WEB_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Reads the flags of the web pages into `config`.
void ReadWebFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_WEB_FLAGS_H_
