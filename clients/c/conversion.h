#ifndef CLIENTS_C_CONVERSION_H_
#define CLIENTS_C_CONVERSION_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "absl/types/span.h"
#include "clients/c/procgen.h"
#include "envcore/environment/level_sampler.h"
#include "envcore/pool/pool.h"
#include "envcore/status/status.h"
#include "procgen_client/pool.h"

// The structs of procgen.h as those of the engine.
namespace procgen_client {

inline constexpr int32_t kNumThreadsMax = 1024;

// Copies the fields that both sides know over `defaults`: programs of other versions have shorter
// or longer structs.
template <typename Struct>
Struct Complete(const Struct& given, Struct defaults = {}) {
  std::memcpy(&defaults, &given, std::min(given.struct_size, sizeof(Struct)));
  return defaults;
}

ProcgenPoolOptions DefaultPoolOptions();
// Sets the first `struct_size` bytes of `options` to the defaults.
void SetDefaults(ProcgenPoolOptions* options, size_t struct_size);

// Spans of an array that may be null when it is empty.
template <typename Element>
absl::Span<const Element> SpanOf(const Element* elements, int64_t count) {
  return absl::MakeConstSpan(elements, static_cast<size_t>(elements == nullptr ? 0 : count));
}

// Without art; draws a rand_seed that is not given. Errors: INVALID_ARGUMENT a pointer or an enum
// that the engine does not check; those of LevelSampler::Create.
procgen::StatusOr<procgen::PoolOptions> PoolOptionsOf(const ProcgenPoolOptions& options);
procgen::StatusOr<std::shared_ptr<const procgen::LevelSampler>> LevelSamplerOf(
    const ProcgenLevelSampler& given);

std::vector<procgen::NextLevel> NextLevelsOf(const ProcgenNextLevel* next_levels, int32_t count);
std::vector<procgen::Reset> ResetsOf(const ProcgenReset* resets, int32_t count);
procgen::StepInput StepInputOf(const ProcgenStep& step,
                               absl::Span<const procgen::NextLevel> next_levels,
                               absl::Span<const procgen::Reset> resets);
// Errors: INVALID_ARGUMENT a null or a count.
procgen::StatusOr<std::vector<Annotation>> AnnotationsOf(const ProcgenStep& step);
// `env_count`: rows. `observation_bytes`: of one row.
procgen::Batch BatchOf(const ProcgenBatch& given, int32_t env_count, size_t observation_bytes);

void Fill(const procgen::PoolOptions& options, int32_t thread_count, ProcgenPoolInfo* info);

}  // namespace procgen_client

#endif  // CLIENTS_C_CONVERSION_H_
