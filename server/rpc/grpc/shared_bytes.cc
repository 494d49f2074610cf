#include "server/rpc/grpc/shared_bytes.h"

#include <cstddef>
#include <memory>
#include <vector>

#include "absl/strings/string_view.h"
#include "grpcpp/support/slice.h"

namespace procgen {
namespace {

// Slices up to this size are copied, which is cheaper than sharing. Slices with inline bytes, which
// could not be shared in this way, are smaller.
constexpr size_t kCopiedBytesMax = 512;

}  // namespace

absl::Cord CordOf(const grpc::ByteBuffer& bytes) {
  std::vector<grpc::Slice> slices;
  bytes.Dump(&slices).ok();  // fails only without a buffer, and then there are no slices
  absl::Cord cord;
  for (const grpc::Slice& slice : slices) {
    const absl::string_view view(reinterpret_cast<const char*>(slice.begin()), slice.size());
    if (view.size() <= kCopiedBytesMax) {
      cord.Append(view);
    } else {
      cord.Append(absl::MakeCordFromExternal(view, [slice] {}));
    }
  }
  return cord;
}

grpc::ByteBuffer ByteBufferOf(const absl::Cord& bytes) {
  std::vector<grpc::Slice> slices;
  using SharedCord = std::shared_ptr<const absl::Cord>;
  const auto release = [](void* held) { delete static_cast<SharedCord*>(held); };
  // On the heap, because a short Cord stores its bytes inline.
  const auto whole = std::make_shared<const absl::Cord>(bytes);
  for (const absl::string_view chunk : whole->Chunks()) {
    // Each slice keeps the whole Cord alive. gRPC only reads the bytes, although its type is not
    // const.
    slices.emplace_back(const_cast<char*>(chunk.data()), chunk.size(), release,
                        new SharedCord(whole));
  }
  return {slices.data(), slices.size()};
}

}  // namespace procgen
