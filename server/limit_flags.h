#ifndef SERVER_LIMIT_FLAGS_H_
#define SERVER_LIMIT_FLAGS_H_

#include "server/pool/quota/limits.h"

namespace procgen {

// The limits that the flags set, not yet validated.
Limits ReadLimitFlags();

}  // namespace procgen

#endif  // SERVER_LIMIT_FLAGS_H_
