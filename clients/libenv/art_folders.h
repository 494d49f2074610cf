#ifndef CLIENTS_LIBENV_ART_FOLDERS_H_
#define CLIENTS_LIBENV_ART_FOLDERS_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "envcore/pool/shared_art.h"

namespace procgen {

// The art in a folder, as the option resource_root names it. While any handle draws with it, all
// that name the folder in the same way share it and nothing is read again. Null: an empty name, so
// the built-in art. Errors: those of SharedArt::LoadFolder. Threads: any.
absl::StatusOr<std::shared_ptr<const SharedArt>> FindArt(const std::string& folder);

}  // namespace procgen

#endif  // CLIENTS_LIBENV_ART_FOLDERS_H_
