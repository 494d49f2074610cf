#include "server/rpc/grpc/shared_bytes.h"

#include <cstddef>
#include <memory>
#include <vector>

#include "absl/strings/string_view.h"
#include "grpcpp/support/slice.h"

namespace procgen {
namespace {

// So few bytes are sooner copied than shared. Short slices, which hold their bytes in themselves,
// could not be shared so.
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
