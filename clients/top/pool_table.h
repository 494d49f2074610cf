#ifndef CLIENTS_TOP_POOL_TABLE_H_
#define CLIENTS_TOP_POOL_TABLE_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "clients/top/rate_history.h"
#include "clients/top/sample.h"

namespace procgen_top {

// What the pools are sorted by. Numbers descend, names ascend.
enum class SortKey { kSteps, kReturn, kLength, kLatency, kAge, kName };

// A sort key, its name as a flag's value and the key of the keyboard that chooses it.
struct SortChoice {
  SortKey sort_key;
  const char* name;
  char letter;
};
const std::vector<SortChoice>& SortChoices();
// The sort key of a name, if it is one.
std::optional<SortKey> SortKeyOf(absl::string_view name);

struct PoolTableOptions {
  SortKey sort_key = SortKey::kSteps;
  bool is_reversed = false;
  bool is_utf8 = true;  // whether the terminal shows UTF-8
};

// The pools as a table: its head and a line for each pool. Pools of equal values are sorted by
// name.
std::vector<std::string> PoolTableOf(const Sample& now, const RateHistory& history,
                                     const PoolTableOptions& options);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_POOL_TABLE_H_
