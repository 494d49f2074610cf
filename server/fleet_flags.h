#ifndef SERVER_FLEET_FLAGS_H_
#define SERVER_FLEET_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Puts into `config` what the flags say of a fleet.
void ReadFleetFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_FLEET_FLAGS_H_
