#include "clients/top/text_table.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace procgen_top {
namespace {

// Whether a character of UTF-8 begins with this byte.
bool BeginsCharacter(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; }

size_t WidthOf(absl::string_view text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), BeginsCharacter));
}

}  // namespace

std::vector<std::string> AlignedLines(const std::vector<Column>& columns,
                                      const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::string> lines(rows.size() + 1);
  for (size_t i = 0; i < columns.size(); ++i) {
    size_t width = WidthOf(columns[i].head);
    for (const std::vector<std::string>& row : rows) {
      width = std::max(width, WidthOf(row[i]));
    }
    for (size_t line = 0; line < lines.size(); ++line) {
      const std::string& cell = line == 0 ? columns[i].head : rows[line - 1][i];
      const std::string space(width - WidthOf(cell), ' ');
      absl::StrAppend(&lines[line], i == 0 ? "" : "  ", columns[i].is_number ? space : "", cell,
                      columns[i].is_number ? "" : space);
    }
  }
  for (std::string& line : lines) {
    absl::StripTrailingAsciiWhitespace(&line);
  }
  return lines;
}

absl::string_view FirstCharacters(absl::string_view text, size_t width) {
  size_t end = 0;
  for (size_t count = 0; end < text.size(); ++end) {
    count += BeginsCharacter(text[end]) ? 1 : 0;
    if (count > width) {
      break;
    }
  }
  return text.substr(0, end);
}

std::string Shown(const std::string& text) { return text.empty() ? "-" : absl::CHexEscape(text); }

}  // namespace procgen_top
