#include "tests/fuzz/pieces.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>

namespace procgen {
namespace {

constexpr size_t kMarkLength = 65535;

}  // namespace

void Require(bool holds, absl::string_view claim, const absl::Status& status) {
  if (!holds) {
    std::cerr << "broken claim: " << claim << ": " << status << std::endl;
    std::abort();
  }
}

std::vector<Piece> PiecesOf(const uint8_t* bytes, size_t size) {
  std::vector<Piece> pieces;
  size_t position = 0;
  while (size - position >= 2) {
    size_t length = bytes[position] + (size_t{bytes[position + 1]} << 8U);
    position += 2;
    Piece& piece = pieces.emplace_back();
    piece.is_mark = length == kMarkLength;
    length = piece.is_mark ? 0 : std::min(length, size - position);
    piece.bytes.assign(reinterpret_cast<const char*>(bytes + position), length);
    position += length;
  }
  return pieces;
}

}  // namespace procgen
