#include "envcore/art/embedded_art.h"

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "absl/strings/string_view.h"

// The blob written by pack.py, included by embedded_art.S.
extern "C" const char procgen_art_blob[];  // NOLINT: the assembler's name

namespace procgen {
namespace {

uint32_t NumberAt(size_t index) {
  uint32_t number = 0;
  std::memcpy(&number, procgen_art_blob + index * sizeof(number), sizeof(number));
  return number;
}

}  // namespace

std::vector<EmbeddedFile> EmbeddedArt() {
  const size_t count = NumberAt(0);
  std::vector<EmbeddedFile> files(count);
  const char* at = procgen_art_blob + (1 + 2 * count) * sizeof(uint32_t);
  for (size_t i = 0; i < count; ++i) {
    files[i].name = absl::string_view(at, NumberAt(1 + 2 * i));
    at += files[i].name.size();
  }
  for (size_t i = 0; i < count; ++i) {
    files[i].png = absl::string_view(at, NumberAt(2 + 2 * i));
    at += files[i].png.size();
  }
  return files;
}

}  // namespace procgen
