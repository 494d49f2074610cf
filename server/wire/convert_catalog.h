#ifndef SERVER_WIRE_CONVERT_CATALOG_H_
#define SERVER_WIRE_CONVERT_CATALOG_H_

#include "absl/strings/string_view.h"
#include "procgen/v1/catalog.pb.h"
#include "server/pool/pool_supervisor.h"
#include "server/pool/quota/limits.h"

namespace procgen {

// Properties of a server that its catalog contains.
struct ServerInfo {
  absl::string_view version = "";
  bool has_own_art = false;  // draws with --art_dir
};

v1::Catalog CatalogMessageOf(const ServerInfo& server, const Limits& limits);

v1::Load LoadMessageOf(const Load& load, const StreamTotals& streams);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_CATALOG_H_
