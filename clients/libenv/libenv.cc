#include "clients/libenv/libenv.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/libenv/handle.h"

namespace {

constexpr int kInterfaceVersion = 1;

void ReportFailure(const char* function, absl::string_view what) {
  procgen::Report(absl::StrCat(function, ": ", what));
}

// Runs the body of an interface function and reports its error or exception, which must not reach
// the host.
template <typename Body>
void Guard(const char* function, const Body& body) noexcept {
  try {
    if (const absl::Status status = body(); !status.ok()) {
      ReportFailure(function, status.message());
    }
  } catch (const std::exception& error) {
    ReportFailure(function, error.what());
  } catch (...) {
    ReportFailure(function, "failed for an unknown reason");
  }
}

// As Guard, for functions that need a handle.
template <typename Body>
void GuardWith(const char* function, const LibenvHandle* handle, const Body& body) noexcept {
  Guard(function, [&] {
    return handle == nullptr ? absl::InvalidArgumentError("the handle is null") : body();
  });
}

}  // namespace

int libenv_version() { return kInterfaceVersion; }

LibenvHandle* libenv_make(int env_count, LibenvOptions options) {
  LibenvHandle* made = nullptr;
  Guard("libenv_make", [&] {
    auto handle = LibenvHandle::Create(env_count, options);
    if (handle.ok()) {
      made = handle->release();
    }
    return handle.status();
  });
  return made;
}

int libenv_get_tensortypes(LibenvHandle* handle, int space, LibenvTensorType* types) {
  int member_count = 0;
  GuardWith("libenv_get_tensortypes", handle, [&] {
    const std::vector<LibenvTensorType> members = handle->TensorTypes(space);
    if (types != nullptr) {
      std::copy(members.begin(), members.end(), types);
    }
    member_count = static_cast<int>(members.size());
    return absl::OkStatus();
  });
  return member_count;
}

void libenv_set_buffers(LibenvHandle* handle, LibenvBuffers* buffers) {
  GuardWith("libenv_set_buffers", handle, [&] {
    return buffers == nullptr ? absl::InvalidArgumentError("buffers is null")
                              : handle->SetBuffers(*buffers);
  });
}

void libenv_observe(LibenvHandle* handle) {
  GuardWith("libenv_observe", handle, [&] { return handle->Observe(); });
}

void libenv_act(LibenvHandle* handle) {
  GuardWith("libenv_act", handle, [&] { return handle->Act(); });
}

void libenv_close(LibenvHandle* handle) {
  Guard("libenv_close", [&] {
    const std::unique_ptr<LibenvHandle> owned(handle);
    return absl::OkStatus();
  });
}

int get_state(LibenvHandle* handle, int environment, char* data, int length) {
  int size = 0;
  GuardWith("get_state", handle, [&] {
    const size_t room = data == nullptr ? 0 : static_cast<size_t>(std::max(length, 0));
    const auto saved = handle->SaveState(environment, absl::MakeSpan(data, room));
    size = saved.ok() ? *saved : 0;
    return saved.status();
  });
  return size;
}

void set_state(LibenvHandle* handle, int environment, char* data, int length) {
  GuardWith("set_state", handle, [&] {
    const size_t size = data == nullptr ? 0 : static_cast<size_t>(std::max(length, 0));
    return handle->RestoreState(environment, absl::string_view(data, size));
  });
}
