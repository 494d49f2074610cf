#ifndef SERVER_FLEET_FLAGS_H_
#define SERVER_FLEET_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Reads the fleet flags into `config`.
void ReadFleetFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_FLEET_FLAGS_H_
