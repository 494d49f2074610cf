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
  using Held = std::shared_ptr<const absl::Cord>;
  const auto let_go = [](void* held) { delete static_cast<Held*>(held); };
  // On the heap, because a short Cord holds its bytes in itself.
  const auto whole = std::make_shared<const absl::Cord>(bytes);
  for (const absl::string_view chunk : whole->Chunks()) {
    // Each slice holds the whole. gRPC only reads what it sends; its type does not say so.
    slices.emplace_back(const_cast<char*>(chunk.data()), chunk.size(), let_go, new Held(whole));
  }
  return {slices.data(), slices.size()};
}

}  // namespace procgen
