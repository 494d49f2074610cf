// The functions of procgen.h that read and edit states.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "clients/c/call_guard.h"
#include "clients/c/procgen.h"
#include "envcore/environment/readable_state.h"
#include "envcore/games/game_objects.h"
#include "envcore/status/status.h"

namespace {

using procgen_client::CheckArray;
using procgen_client::CheckNotNull;
using procgen_client::FirstError;
using procgen_client::Guard;
using procgen_client::GuardPool;

static_assert(sizeof(ProcgenObject) == sizeof(procgen::ObjectRow));

using Conversion = procgen::StatusOr<std::string> (*)(absl::string_view);

// Writes what `conversion` makes of an input.
ProcgenCode Convert(Conversion conversion, const void* input, size_t input_size, void* output,
                    size_t capacity, size_t* output_size) noexcept {
  return Guard([&]() -> procgen::Status {
    if (procgen::Status status =
            FirstError({CheckNotNull(input, "the input"), CheckNotNull(output_size, "the size")});
        !status.ok()) {
      return status;
    }
    const auto converted = conversion({static_cast<const char*>(input), input_size});
    if (!converted.ok()) {
      return converted.status();
    }
    *output_size = converted->size();
    if (converted->size() > capacity) {
      return procgen::ResourceExhaustedError(
          absl::StrCat("capacity is ", capacity, " bytes, the output has ", converted->size()));
    }
    std::memcpy(output, converted->data(), converted->size());
    return procgen::OkStatus();
  });
}

}  // namespace

ProcgenCode procgen_state_to_json(const uint8_t* snapshot, size_t snapshot_size, char* json,
                                  size_t capacity, size_t* json_size) {
  return Convert(procgen::SnapshotToJson, snapshot, snapshot_size, json, capacity, json_size);
}

ProcgenCode procgen_state_from_json(const char* json, size_t json_size, uint8_t* snapshot,
                                    size_t capacity, size_t* snapshot_size) {
  return Convert(procgen::SnapshotFromJson, json, json_size, snapshot, capacity, snapshot_size);
}

ProcgenCode procgen_read_objects(ProcgenPool* pool, int32_t first_env, int32_t env_count,
                                 int32_t object_max, ProcgenObject* objects, int32_t* counts) {
  return GuardPool(pool, [&](procgen_client::Pool& of) {
    if (procgen::Status status =
            FirstError({CheckArray(objects, "objects", object_max, "object_max"),
                        CheckArray(counts, "counts", env_count, "env_count")});
        !status.ok()) {
      return status;
    }
    const auto rows = static_cast<size_t>(env_count);
    return of.ReadObjects(first_env, env_count, object_max,
                          absl::MakeSpan(reinterpret_cast<procgen::ObjectRow*>(objects),
                                         rows * static_cast<size_t>(object_max)),
                          absl::MakeSpan(counts, rows));
  });
}
