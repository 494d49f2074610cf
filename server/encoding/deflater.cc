#include "server/encoding/deflater.h"

#include "server/encoding/check.h"

namespace procgen {
namespace {

// The largest level whose search is the fast one; higher ones save a tenth and take 1.5 times as
// long.
constexpr int kLevel = 3;
constexpr int kRawWindowBits = -15;  // negative: without a header and a checksum
constexpr int kMemoryLevel = 8;      // zlib's default
// A flush adds an empty block.
constexpr size_t kFlushBytes = 16;

}  // namespace

Deflater::Deflater() {
  Check(deflateInit2(&stream_, kLevel, Z_DEFLATED, kRawWindowBits, kMemoryLevel,
                     Z_DEFAULT_STRATEGY) == Z_OK,
        "no memory for zlib");
}

Deflater::~Deflater() { deflateEnd(&stream_); }

std::string Deflater::Deflate(absl::Span<const uint8_t> bytes,
                              absl::Span<const uint8_t> dictionary) {
  Check(deflateReset(&stream_) == Z_OK, "the stream is reset");
  if (!dictionary.empty()) {
    Check(deflateSetDictionary(&stream_, dictionary.data(), static_cast<uInt>(dictionary.size())) ==
              Z_OK,
          "zlib takes a dictionary");
  }
  std::string blocks(deflateBound(&stream_, bytes.size()) + kFlushBytes, '\0');
  stream_.next_in = const_cast<Bytef*>(bytes.data());
  stream_.avail_in = static_cast<uInt>(bytes.size());
  stream_.next_out = reinterpret_cast<Bytef*>(blocks.data());
  stream_.avail_out = static_cast<uInt>(blocks.size());
  Check(deflate(&stream_, Z_SYNC_FLUSH) == Z_OK && stream_.avail_in == 0 && stream_.avail_out > 0,
        "blocks of zlib are larger than their bound");
  blocks.resize(blocks.size() - stream_.avail_out);
  return blocks;
}

}  // namespace procgen
