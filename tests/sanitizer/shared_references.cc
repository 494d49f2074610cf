// Tells ThreadSanitizer that whoever lets go of the last reference comes after all who let go
// before. absl::Status and the slices of gRPC's buffers count their references with atomics inside
// of Debian's libraries, which are built without the sanitizer.
//
// Linked into every program of the tsan preset, these definitions come before the library's and
// call them.

#include <sanitizer/tsan_interface.h>

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "grpc/byte_buffer.h"
#include "grpc/slice.h"
#include "tests/sanitizer/library_function.h"

namespace {

constexpr char kStatusLibrary[] = "libabsl_status.so.20220623";
constexpr char kGrpcLibrary[] = "libgrpc.so.29";

// `shared`: what is counted, by its address; null: not counted.
void LetGo(void* shared) {
  if (shared != nullptr) {
    __tsan_release(shared);
    __tsan_acquire(shared);
  }
}

}  // namespace

namespace absl {
ABSL_NAMESPACE_BEGIN

void Status::UnrefNonInlined(uintptr_t rep) {
  static auto* const next = procgen::LibraryFunction<void(uintptr_t)>(
      kStatusLibrary, "_ZN4absl7debian36Status15UnrefNonInlinedEm");
  LetGo(reinterpret_cast<void*>(rep));
  next(rep);
}

ABSL_NAMESPACE_END
}  // namespace absl

void grpc_slice_unref(grpc_slice slice) {
  static auto* const next =
      procgen::LibraryFunction<decltype(grpc_slice_unref)>(kGrpcLibrary, "grpc_slice_unref");
  LetGo(slice.refcount);
  next(slice);
}

void grpc_byte_buffer_destroy(grpc_byte_buffer* buffer) {
  static auto* const next = procgen::LibraryFunction<decltype(grpc_byte_buffer_destroy)>(
      kGrpcLibrary, "grpc_byte_buffer_destroy");
  if (buffer != nullptr && buffer->type == GRPC_BB_RAW) {
    const grpc_slice_buffer& slices = buffer->data.raw.slice_buffer;
    for (size_t i = 0; i < slices.count; ++i) {
      LetGo(slices.slices[i].refcount);
    }
  }
  next(buffer);
}
