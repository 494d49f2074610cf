#include "envcore/render/art/column_copies.h"

#include <memory>

namespace procgen {
namespace {

// Never 0 in the high bits, so that no part equals an empty counter.
uint64_t HashOf(const ColumnCopies::Part& part) {
  constexpr uint64_t kMultiplier = 0x9E3779B97F4A7C15;
  uint64_t hash = static_cast<uint64_t>(part.position) * kMultiplier;
  hash = (hash ^ (hash >> 32) ^ static_cast<uint64_t>(part.step)) * kMultiplier;
  hash = (hash ^ (hash >> 32) ^ static_cast<uint64_t>(part.first_row)) * kMultiplier;
  return hash | uint64_t{1} << 63;
}

Image CopyOf(const Image& source, const ColumnCopies::Part& part) {
  Image copy(part.width, part.end_row - part.first_row);
  for (int y = 0; y < copy.height(); ++y) {
    const Rgba* from = source.Row(part.first_row + y);
    Rgba* to = copy.Row(y);
    for (int x = 0; x < part.width; ++x) {
      to[x] = from[(part.position + x * part.step) >> 16];
    }
  }
  return copy;
}

}  // namespace

ColumnCopies::~ColumnCopies() {
  for (Bucket& bucket : buckets_) {
    for (const Entry* entry = bucket.first; entry != nullptr;) {
      const std::unique_ptr<const Entry> owned(entry);
      entry = entry->next;
    }
  }
}

const Image* ColumnCopies::Find(const Image& source, const Part& part) const {
  constexpr uint64_t kCountBits = 0xff;
  const uint64_t hash = HashOf(part);
  Bucket& bucket = buckets_[(hash >> 40) % buckets_.size()];
  for (const Entry* entry = bucket.first.load(std::memory_order_acquire); entry != nullptr;
       entry = entry->next) {
    if (entry->part == part) {
      return &entry->image;
    }
  }
  const uint64_t last = bucket.missing.load(std::memory_order_relaxed);
  const uint64_t count = (last ^ hash) > kCountBits ? 1 : (last & kCountBits) + 1;
  if (count < kRequestsMin) {
    bucket.missing.store((hash & ~kCountBits) | count, std::memory_order_relaxed);
    return nullptr;
  }
  return Make(source, part, &bucket);
}

const Image* ColumnCopies::Make(const Image& source, const Part& part, Bucket* bucket) const {
  const auto bytes =
      static_cast<int64_t>(sizeof(Rgba)) * part.width * (part.end_row - part.first_row);
  if (kept_bytes_.fetch_add(bytes, std::memory_order_relaxed) + bytes > kKeptBytesMax) {
    kept_bytes_.fetch_sub(bytes, std::memory_order_relaxed);
    return nullptr;
  }
  auto made = std::make_unique<Entry>();
  made->part = part;
  made->image = CopyOf(source, part);
  // Two threads may make the same copy; both stay.
  made->next = bucket->first.load(std::memory_order_relaxed);
  while (!bucket->first.compare_exchange_weak(made->next, made.get(), std::memory_order_acq_rel,
                                              std::memory_order_relaxed)) {
  }
  return &made.release()->image;
}

}  // namespace procgen
