#ifndef SERVER_FLAGS_H_
#define SERVER_FLAGS_H_

#include "absl/status/statusor.h"
#include "server/config.h"

namespace procgen {

// Returns what the flags of procgen-server say, checked, with the files that they name. REQUIRES:
// the command line was parsed. Errors: as CheckConfig and LoadSecrets; the art cannot be used.
absl::StatusOr<Config> ReadFlags();

}  // namespace procgen

#endif  // SERVER_FLAGS_H_
