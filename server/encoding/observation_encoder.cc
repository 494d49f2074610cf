#include "server/encoding/observation_encoder.h"

#include <algorithm>
#include <cstring>

#include "server/encoding/check.h"

namespace procgen {
namespace {

constexpr int32_t kSideMax = 512;

uint8_t NextAge(uint8_t age) { return age == 255 ? 1 : static_cast<uint8_t>(age + 1); }

}  // namespace

ObservationEncoder::ObservationEncoder(const PictureShape& shape, int32_t env_count)
    : shape_(shape),
      environments_(static_cast<size_t>(env_count)),
      shown_(static_cast<size_t>(env_count) * shape.bytes()) {
  Check(env_count > 0, "a pool has environments");
  Check(shape.columns > 0 && shape.columns <= kSideMax, "columns out of range");
  Check(shape.pixel_bytes == 1 || shape.pixel_bytes == 3, "no such pixels");
  Check(shape.stack > 0 && shape.rows > 0 && shape.rows % shape.stack == 0,
        "the pictures of a stack are of one size");
}

size_t ObservationEncoder::EncodedBytesMax(const PictureShape& shape) {
  const auto blocks = static_cast<size_t>(shape.block_count());
  const size_t numbers = 2 + shape.block_map_bytes() + blocks * (3 + kBlockSide);
  return Compressor::FrameBytesMax(numbers + shape.bytes());
}

int32_t ObservationEncoder::FindAdvance(const uint8_t* before, const uint8_t* now) const {
  const size_t picture_bytes = shape_.bytes() / static_cast<size_t>(shape_.stack);
  // A step shifts the stack by one; steps without observations shift it further.
  for (int32_t advance = 1; advance < shape_.stack; ++advance) {
    if (std::memcmp(now, before + static_cast<size_t>(advance) * picture_bytes, picture_bytes) ==
        0) {
      return advance;
    }
  }
  return 0;
}

void ObservationEncoder::Advance(int32_t count, uint8_t* before) const {
  const size_t picture_bytes = shape_.bytes() / static_cast<size_t>(shape_.stack);
  const size_t gone = static_cast<size_t>(count) * picture_bytes;
  std::memmove(before, before + gone, shape_.bytes() - gone);
  // The freed places repeat the last frame.
  const uint8_t* last = before + shape_.bytes() - picture_bytes;
  for (uint8_t* place = before + shape_.bytes() - gone; place < last; place += picture_bytes) {
    std::memcpy(place, last, picture_bytes);
  }
}

void ObservationEncoder::Append(size_t environment, const uint8_t* now) {
  Environment& state = environments_[environment];
  uint8_t* before = shown_.data() + environment * shape_.bytes();
  *ages_.Room(1) = state.age;
  ages_.Extend(1);
  if (shape_.stack > 1) {
    const int32_t advance = state.age == 0 ? 0 : FindAdvance(before, now);
    Advance(advance, before);
    *advances_.Room(1) = static_cast<uint8_t>(advance);
    advances_.Extend(1);
  }
  AppendDelta(shape_, before, now, state.search, delta_);
  std::memcpy(before, now, shape_.bytes());
  state.age = NextAge(state.age);
}

std::string ObservationEncoder::Encode(int32_t first, int32_t count,
                                       absl::Span<const uint8_t> observations) {
  Check(first >= 0 && count > 0 &&
            static_cast<size_t>(first) + static_cast<size_t>(count) <= environments_.size() &&
            observations.size() == static_cast<size_t>(count) * shape_.bytes(),
        "a slice of the pool, with its observations");
  ages_.Clear();
  advances_.Clear();
  delta_.Clear();
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    Append(static_cast<size_t>(first) + i, observations.data() + i * shape_.bytes());
  }
  numbers_.clear();
  for (const ByteList* list : {&ages_, &advances_, &delta_.changed, &delta_.move_rows,
                               &delta_.move_columns, &delta_.patched, &delta_.masks}) {
    numbers_.insert(numbers_.end(), list->bytes().begin(), list->bytes().end());
  }
  return compressor_.Compress(numbers_, delta_.pixels.bytes());
}

}  // namespace procgen
