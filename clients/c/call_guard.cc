#include "clients/c/call_guard.h"

#include "absl/strings/str_cat.h"

namespace procgen_client {
namespace {

thread_local std::string error_message;

}  // namespace

procgen::Status ProcessOwner::Check(absl::string_view object) const {
  return is_this_process()
             ? procgen::OkStatus()
             : procgen::FailedPreconditionError(absl::StrCat(
                   "the ", object, " belongs to process ", process_id_, ", of which this one, ",
                   getpid(), ", is a fork: create another ", object, " here"));
}

const std::string& ErrorMessage() { return error_message; }

ProcgenCode Fail(const procgen::Status& status) {
  error_message = std::string(status.message());
  return static_cast<ProcgenCode>(status.code());
}

procgen::Status CheckNotNull(const void* pointer, absl::string_view name) {
  return pointer != nullptr ? procgen::OkStatus()
                            : procgen::InvalidArgumentError(absl::StrCat(name, " is null"));
}

procgen::Status CheckArray(const void* array, absl::string_view name, int64_t count,
                           absl::string_view count_name) {
  if (count < 0) {
    return procgen::InvalidArgumentError(absl::StrCat(count_name, " is ", count));
  }
  if (count > 0 && array == nullptr) {
    return procgen::InvalidArgumentError(absl::StrCat(name, " is null, its length is ", count));
  }
  return procgen::OkStatus();
}

procgen::Status CheckStructSize(const size_t* given, absl::string_view name) {
  if (given != nullptr && *given < sizeof(size_t)) {
    return procgen::InvalidArgumentError(
        absl::StrCat(name, ".struct_size is ", *given, ", must be the size of the struct"));
  }
  return CheckNotNull(given, name);
}

procgen::Status FirstError(std::initializer_list<procgen::Status> statuses) {
  for (const procgen::Status& status : statuses) {
    if (!status.ok()) {
      return status;
    }
  }
  return procgen::OkStatus();
}

}  // namespace procgen_client
