#include "procgen_client/observation_decoder.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "absl/strings/str_cat.h"
#include "procgen_client/internal/frame_content.h"

namespace procgen_client {
namespace {

constexpr int32_t kBlockSide = 8;
constexpr int32_t kSizePxDefault = 64;
constexpr int32_t kSizePxMax = 512;
constexpr int32_t kStackMax = 16;

uint8_t NextAge(uint8_t age) { return age == 255 ? 1 : static_cast<uint8_t>(age + 1); }

int32_t CountBits(uint8_t byte) { return __builtin_popcount(byte); }

// A mask of the lowest `count` bits, 0 <= count <= 8.
uint32_t Bits(int32_t count) { return (1U << count) - 1; }

// Writes the next of `pixels` at each set bit of the mask. Returns the rest of `pixels`.
template <size_t kPixelBytes>
const uint8_t* Patch(uint32_t mask, const uint8_t* pixels, uint8_t* row) {
  for (; mask != 0; mask >>= 1, row += kPixelBytes) {
    if ((mask & 1) != 0) {
      std::memcpy(row, pixels, kPixelBytes);
      pixels += kPixelBytes;
    }
  }
  return pixels;
}

absl::Status Damaged(absl::string_view what) {
  return absl::DataLossError(absl::StrCat("encoded observations: ", what));
}

// Reads consecutive parts of a byte string.
class Reader {
 public:
  explicit Reader(absl::string_view bytes)
      : next_(reinterpret_cast<const uint8_t*>(bytes.data())), left_(bytes.size()) {}

  // The next `count` bytes; false if there are fewer.
  bool Take(size_t count, absl::Span<const uint8_t>& part) {
    if (count > left_) {
      return false;
    }
    part = {next_, count};
    next_ += count;
    left_ -= count;
    return true;
  }
  size_t left() const { return left_; }

 private:
  const uint8_t* next_;
  size_t left_;
};

size_t CountAllBits(absl::Span<const uint8_t> bytes) {
  size_t count = 0;
  for (const uint8_t byte : bytes) {
    count += static_cast<size_t>(CountBits(byte));
  }
  return count;
}

}  // namespace

// A block of the plane, in rows and pixels.
struct ObservationDecoder::Block {
  int32_t row = 0;
  int32_t column = 0;
  int32_t height = 0;
  int32_t width = 0;
};

// The tables of the content, and the read position in those of the blocks.
struct ObservationDecoder::Content {
  absl::Span<const uint8_t> ages;
  absl::Span<const uint8_t> advances;
  absl::Span<const uint8_t> changed;
  absl::Span<const uint8_t> move_rows;
  absl::Span<const uint8_t> move_columns;
  absl::Span<const uint8_t> patched;
  absl::Span<const uint8_t> masks;
  absl::Span<const uint8_t> pixels;
  size_t block = 0;
  size_t mask = 0;
  size_t pixel_byte = 0;
};

absl::StatusOr<ObservationDecoder> ObservationDecoder::Make(const procgen::v1::Pool& pool) {
  const procgen::v1::PoolSpec& spec = pool.spec();
  const procgen::v1::ObservationFormat& format = spec.observation_format();
  const int32_t size_px = format.size_px() == 0 ? kSizePxDefault : format.size_px();
  const int32_t stack = std::max(format.frame_stack(), 1);
  if (size_px < 1 || size_px > kSizePxMax || stack > kStackMax || spec.env_count() < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("a pool of ", spec.env_count(), " environments with observations of size ",
                     size_px, " in stacks of ", stack, ", allowed: sizes of 1 to ", kSizePxMax,
                     " and stacks of 1 to ", kStackMax));
  }
  if (spec.encoding() != procgen::v1::ENCODING_DELTA_ZSTD) {
    return absl::InvalidArgumentError(absl::StrCat(
        "encoding is ", static_cast<int>(spec.encoding()), ", allowed: ENCODING_DELTA_ZSTD"));
  }
  const int32_t channels = format.color() == procgen::v1::COLOR_GRAYSCALE ? 1 : 3;
  const bool is_chw = format.layout() == procgen::v1::LAYOUT_CHW;
  Plane plane;
  plane.rows = size_px * stack * (is_chw ? channels : 1);
  plane.columns = size_px;
  plane.pixel_bytes = is_chw ? 1 : channels;
  plane.stack = stack;
  return ObservationDecoder(plane, spec.env_count());
}

ObservationDecoder::ObservationDecoder(const Plane& plane, int32_t env_count)
    : plane_(plane), env_count_(env_count), basis_(plane.bytes()) {}

int32_t ObservationDecoder::block_columns() const {
  return (plane_.columns + kBlockSide - 1) / kBlockSide;
}

int32_t ObservationDecoder::block_count() const {
  return (plane_.rows + kBlockSide - 1) / kBlockSide * block_columns();
}

ObservationDecoder::Block ObservationDecoder::BlockAt(int32_t index) const {
  Block block;
  block.row = index / block_columns() * kBlockSide;
  block.column = index % block_columns() * kBlockSide;
  block.height = std::min(kBlockSide, plane_.rows - block.row);
  block.width = std::min(kBlockSide, plane_.columns - block.column);
  return block;
}

size_t ObservationDecoder::ContentBytesMax(int32_t count) const {
  const auto blocks = static_cast<size_t>(block_count());
  const size_t numbers = 2 + (blocks + 7) / 8 + blocks * (3 + kBlockSide);
  return static_cast<size_t>(count) * (numbers + plane_.bytes());
}

absl::Status ObservationDecoder::CheckAges(int32_t first, const Content& content) const {
  for (size_t i = 0; i < content.ages.size(); ++i) {
    const size_t environment = static_cast<size_t>(first) + i;
    const uint8_t next = environment < ages_.size() ? ages_[environment] : uint8_t{0};
    if (content.ages[i] != 0 && content.ages[i] != next) {
      return absl::FailedPreconditionError(absl::StrCat(
          "encoded observations: environment ", environment, " has age ", content.ages[i],
          ", expected: ", next, " or 0; answers are missing or came twice"));
    }
  }
  for (size_t i = 0; i < content.advances.size(); ++i) {
    if (content.advances[i] >= plane_.stack || (content.ages[i] == 0 && content.advances[i] != 0)) {
      return Damaged(absl::StrCat("a stack of ", plane_.stack, " moves by ", content.advances[i]));
    }
  }
  return absl::OkStatus();
}

absl::Status ObservationDecoder::CheckBlocks(int32_t count, Content& content) const {
  size_t patched = 0;
  size_t mask = 0;
  for (int32_t i = 0; i < count; ++i) {
    const size_t map = static_cast<size_t>(i) * ((static_cast<size_t>(block_count()) + 7) / 8);
    for (int32_t index = 0; index < block_count(); ++index) {
      if ((content.changed[map + static_cast<size_t>(index / 8)] >> (index % 8) & 1) == 0) {
        continue;
      }
      const Block block = BlockAt(index);
      const uint8_t rows = content.patched[patched++];
      if ((rows & ~Bits(block.height)) != 0) {
        return Damaged("a row outside the observation is patched");
      }
      for (int32_t row = 0; row < CountBits(rows); ++row) {
        const uint8_t pixels = content.masks[mask++];
        if (pixels == 0 || (pixels & ~Bits(block.width)) != 0) {
          return Damaged("a patched row has no patched pixel, or one outside the observation");
        }
      }
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<ObservationDecoder::Content> ObservationDecoder::Read(
    int32_t first, int32_t count, absl::string_view bytes) const {
  const auto environments = static_cast<size_t>(count);
  const size_t map_bytes = (static_cast<size_t>(block_count()) + 7) / 8;
  Content content;
  Reader reader(bytes);
  if (!reader.Take(environments, content.ages) ||
      !reader.Take(plane_.stack > 1 ? environments : 0, content.advances) ||
      !reader.Take(environments * map_bytes, content.changed)) {
    return Damaged("truncated in the tables of environments");
  }
  if (absl::Status status = CheckAges(first, content); !status.ok()) {
    return status;
  }
  const auto bits_in_last = static_cast<int32_t>(block_count() - (map_bytes - 1) * 8);
  for (size_t i = map_bytes; i <= content.changed.size(); i += map_bytes) {
    if ((content.changed[i - 1] & ~Bits(bits_in_last)) != 0) {
      return Damaged("a block outside the observation changes");
    }
  }
  const size_t blocks = CountAllBits(content.changed);
  if (!reader.Take(blocks, content.move_rows) || !reader.Take(blocks, content.move_columns) ||
      !reader.Take(blocks, content.patched) ||
      !reader.Take(CountAllBits(content.patched), content.masks) ||
      !reader.Take(CountAllBits(content.masks) * static_cast<size_t>(plane_.pixel_bytes),
                   content.pixels)) {
    return Damaged("truncated in the tables of blocks");
  }
  if (reader.left() != 0) {
    return Damaged(absl::StrCat(reader.left(), " bytes too many"));
  }
  if (absl::Status status = CheckBlocks(count, content); !status.ok()) {
    return status;
  }
  return content;
}

void ObservationDecoder::WriteBasis(size_t environment, int32_t age, int32_t advance,
                                    uint8_t* basis) const {
  if (age == 0) {
    std::fill_n(basis, plane_.bytes(), uint8_t{0});
    return;
  }
  const uint8_t* shown = shown_.data() + environment * plane_.bytes();
  const size_t frame_bytes = plane_.bytes() / static_cast<size_t>(plane_.stack);
  for (int32_t place = 0; place < plane_.stack; ++place) {
    const int32_t from = std::min(place + advance, plane_.stack - 1);
    std::memcpy(basis + static_cast<size_t>(place) * frame_bytes,
                shown + static_cast<size_t>(from) * frame_bytes, frame_bytes);
  }
}

void ObservationDecoder::CopyPixels(const uint8_t* row, int32_t column, int32_t width,
                                    uint8_t* to) const {
  const auto pixel_bytes = static_cast<size_t>(plane_.pixel_bytes);
  if (column >= 0 && column + width <= plane_.columns) {
    std::memcpy(to, row + static_cast<size_t>(column) * pixel_bytes,
                static_cast<size_t>(width) * pixel_bytes);
    return;
  }
  for (int32_t x = 0; x < width; ++x, to += pixel_bytes) {
    const int32_t from = std::clamp(column + x, 0, plane_.columns - 1);
    std::memcpy(to, row + static_cast<size_t>(from) * pixel_bytes, pixel_bytes);
  }
}

void ObservationDecoder::DecodeBlock(const uint8_t* basis, const Block& block, Content& content,
                                     uint8_t* observation) const {
  const auto pixel_bytes = static_cast<size_t>(plane_.pixel_bytes);
  const int32_t row = block.row + static_cast<int8_t>(content.move_rows[content.block]);
  const int32_t column = block.column + static_cast<int8_t>(content.move_columns[content.block]);
  const uint32_t patched = content.patched[content.block++];
  for (int32_t y = 0; y < block.height; ++y) {
    const int32_t from_row = std::clamp(row + y, 0, plane_.rows - 1);
    const uint8_t* from = basis + static_cast<size_t>(from_row) * plane_.row_bytes();
    uint8_t* to = observation + static_cast<size_t>(block.row + y) * plane_.row_bytes() +
                  static_cast<size_t>(block.column) * pixel_bytes;
    CopyPixels(from, column, block.width, to);
    if ((patched >> y & 1) != 0) {
      const uint8_t* pixels = content.pixels.data() + content.pixel_byte;
      const uint8_t* end = pixel_bytes == 3 ? Patch<3>(content.masks[content.mask], pixels, to)
                                            : Patch<1>(content.masks[content.mask], pixels, to);
      content.pixel_byte += static_cast<size_t>(end - pixels);
      ++content.mask;
    }
  }
}

absl::Status ObservationDecoder::Decode(int32_t first, int32_t count, absl::string_view encoded,
                                        absl::Span<uint8_t> observations) {
  if (first < 0 || count < 1 || count > env_count_ - first) {
    return absl::InvalidArgumentError(
        absl::StrCat(count, " environments from ", first, ", the pool has ", env_count_));
  }
  if (observations.size() != static_cast<size_t>(count) * plane_.bytes()) {
    return absl::InvalidArgumentError(
        absl::StrCat("observations has ", observations.size(),
                     " bytes, expected: ", static_cast<size_t>(count) * plane_.bytes()));
  }
  const absl::StatusOr<std::string> bytes = FrameContent(encoded, ContentBytesMax(count));
  if (!bytes.ok()) {
    return bytes.status();
  }
  absl::StatusOr<Content> content = Read(first, count, *bytes);
  if (!content.ok()) {
    return content.status();
  }
  const auto end = static_cast<size_t>(first) + static_cast<size_t>(count);
  if (ages_.size() < end) {
    ages_.resize(end);
    shown_.resize(end * plane_.bytes());
  }
  const size_t map_bytes = (static_cast<size_t>(block_count()) + 7) / 8;
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const size_t environment = static_cast<size_t>(first) + i;
    const uint8_t age = content->ages[i];
    uint8_t* observation = observations.data() + i * plane_.bytes();
    uint8_t* shown = shown_.data() + environment * plane_.bytes();
    const uint8_t advance = content->advances.empty() ? 0 : content->advances[i];
    const bool as_shown = age != 0 && advance == 0;
    if (!as_shown) {
      WriteBasis(environment, age, advance, basis_.data());
    }
    const uint8_t* basis = as_shown ? shown : basis_.data();
    std::memcpy(observation, basis, plane_.bytes());
    const uint8_t* changed = content->changed.data() + i * map_bytes;
    for (int32_t index = 0; index < block_count(); ++index) {
      if ((changed[index / 8] >> (index % 8) & 1) != 0) {
        DecodeBlock(basis, BlockAt(index), *content, observation);
      }
    }
    std::memcpy(shown, observation, plane_.bytes());
    ages_[environment] = NextAge(age);
  }
  return absl::OkStatus();
}

}  // namespace procgen_client
