#include "server/rpc/shared_bytes.h"

#include <memory>
#include <vector>

#include "absl/strings/string_view.h"
#include "grpcpp/support/slice.h"

namespace procgen {

absl::Cord CordOf(const grpc::ByteBuffer& bytes) {
  std::vector<grpc::Slice> slices;
  bytes.Dump(&slices).ok();  // fails only without a buffer, and then there are no slices
  absl::Cord cord;
  for (const grpc::Slice& slice : slices) {
    // On the heap, because short slices hold their bytes in themselves.
    auto held = std::make_unique<grpc::Slice>(slice);
    const absl::string_view view(reinterpret_cast<const char*>(held->begin()), held->size());
    cord.Append(absl::MakeCordFromExternal(view, [held = std::move(held)] {}));
  }
  return cord;
}

grpc::ByteBuffer ByteBufferOf(const absl::Cord& bytes) {
  std::vector<grpc::Slice> slices;
  const auto let_go = [](void* held) { delete static_cast<absl::Cord*>(held); };
  for (const absl::string_view chunk : bytes.Chunks()) {
    // Each slice holds the whole: it has its memory, and the chunk is a part of that.
    auto held = std::make_unique<absl::Cord>(bytes);
    // gRPC only reads what it sends; its type does not say so.
    slices.emplace_back(const_cast<char*>(chunk.data()), chunk.size(), let_go, held.release());
  }
  return {slices.data(), slices.size()};
}

}  // namespace procgen
