#ifndef PROCGEN_CLIENT_ART_FOLDERS_H_
#define PROCGEN_CLIENT_ART_FOLDERS_H_

#include <memory>
#include <string>

#include "envcore/pool/shared_art.h"
#include "envcore/status/status.h"

namespace procgen_client {

// Returns the art in a folder; null for an empty name, which selects the built-in art. Pools with
// the same folder share the art while any of them exists. Errors: those of SharedArt::LoadFolder.
// Threads: any.
procgen::StatusOr<std::shared_ptr<const procgen::SharedArt>> FindArt(const std::string& folder);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_ART_FOLDERS_H_
