#ifndef CLIENTS_LIBENV_ART_FOLDERS_H_
#define CLIENTS_LIBENV_ART_FOLDERS_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "envcore/pool/shared_art.h"

namespace procgen {

// Returns the art in the folder that the option resource_root names; null for an empty name, which
// selects the built-in art. Handles with the same name share the art while any of them is open.
// Errors: those of SharedArt::LoadFolder. Threads: any.
absl::StatusOr<std::shared_ptr<const SharedArt>> FindArt(const std::string& folder);

}  // namespace procgen

#endif  // CLIENTS_LIBENV_ART_FOLDERS_H_
