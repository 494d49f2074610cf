#ifndef CLIENTS_TOP_TEXT_TABLE_H_
#define CLIENTS_TOP_TEXT_TABLE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace procgen_top {

struct Column {
  std::string head;
  bool is_number = false;  // aligned to the right
};

// A table as lines, the first of which has the heads of the columns. REQUIRES: each row has a cell
// for each column.
std::vector<std::string> AlignedLines(const std::vector<Column>& columns,
                                      const std::vector<std::vector<std::string>>& rows);

// The first `width` characters of a UTF-8 text.
absl::string_view FirstCharacters(absl::string_view text, size_t width);

// Escapes text of the server, which must not control the terminal; "-" if it is empty.
std::string Shown(const std::string& text);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_TEXT_TABLE_H_
