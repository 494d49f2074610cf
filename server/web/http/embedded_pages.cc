#include "server/web/http/embedded_pages.h"

#include <cstddef>
#include <cstdint>
#include <cstring>

// Defined in embedded_pages.S.in.
extern "C" const char procgen_web_pages[];  // NOLINT: the assembler's name

namespace procgen::web {
namespace {

uint32_t NumberAt(size_t index) {
  uint32_t number = 0;
  std::memcpy(&number, procgen_web_pages + index * sizeof(number), sizeof(number));
  return number;
}

}  // namespace

std::vector<EmbeddedPage> EmbeddedPages() {
  const size_t count = NumberAt(0);
  std::vector<EmbeddedPage> pages(count);
  const char* at = procgen_web_pages + (1 + 2 * count) * sizeof(uint32_t);
  for (size_t i = 0; i < count; ++i) {
    pages[i].name = absl::string_view(at, NumberAt(1 + 2 * i));
    at += pages[i].name.size();
  }
  for (size_t i = 0; i < count; ++i) {
    pages[i].contents = absl::string_view(at, NumberAt(2 + 2 * i));
    at += pages[i].contents.size();
  }
  return pages;
}

}  // namespace procgen::web
