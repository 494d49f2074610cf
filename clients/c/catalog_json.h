#ifndef CLIENTS_C_CATALOG_JSON_H_
#define CLIENTS_C_CATALOG_JSON_H_

#include <string>

namespace procgen_client {

// The catalog of games as JSON:
//   {"actions": [{"name": "LEFT+DOWN", "keys": ["LEFT", "DOWN"]}, ...],
//    "games": [{"name", "description",
//               "modes": {"easy": {"time_limit_steps", "return_range": [min, max] or null,
//                                  "level_seed": only of exploration}, ...},
//               "special_actions": {"9": description, ...},
//               "kinds": [{"kind": number, "name", "is_goal"}, ...],
//               "variants": {name: description, ...}}, ...]}
std::string CatalogJson();

}  // namespace procgen_client

#endif  // CLIENTS_C_CATALOG_JSON_H_
