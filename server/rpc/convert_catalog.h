#ifndef SERVER_RPC_CONVERT_CATALOG_H_
#define SERVER_RPC_CONVERT_CATALOG_H_

#include "absl/strings/string_view.h"
#include "procgen/v1/catalog.pb.h"
#include "server/session/limits.h"
#include "server/session/sessions.h"

namespace procgen {

// What a server of `server_version` with `limits` offers. `has_own_art`: it draws with art that its
// operator gave.
v1::Catalog CatalogMessageOf(absl::string_view server_version, const Limits& limits,
                             bool has_own_art);

v1::Load LoadMessageOf(const Load& load, const StreamTotals& streams);

}  // namespace procgen

#endif  // SERVER_RPC_CONVERT_CATALOG_H_
