#include "clients/c/procgen.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "clients/c/call_guard.h"
#include "clients/c/catalog_json.h"
#include "clients/c/conversion.h"
#include "envcore/status/status.h"
#include "procgen_client/art_folders.h"
#include "procgen_client/local_pool.h"

namespace {

using procgen_client::BatchOf;
using procgen_client::CheckArray;
using procgen_client::CheckNotNull;
using procgen_client::CheckStruct;
using procgen_client::Complete;
using procgen_client::FirstError;
using procgen_client::Guard;
using procgen_client::GuardPool;
using procgen_client::ResetsOf;
using procgen_client::StepInputOf;

procgen::Status Create(const ProcgenPoolOptions& given, ProcgenPool** pool) {
  const ProcgenPoolOptions options = Complete(given, procgen_client::DefaultPoolOptions());
  auto pool_options = procgen_client::PoolOptionsOf(options);
  if (!pool_options.ok()) {
    return pool_options.status();
  }
  auto art = procgen_client::FindArt(options.art == nullptr ? "" : options.art);
  if (!art.ok()) {
    return art.status();
  }
  pool_options->art = *std::move(art);
  if (options.num_threads < -1 || options.num_threads > procgen_client::kNumThreadsMax) {
    return procgen::InvalidArgumentError(absl::StrCat("num_threads is ", options.num_threads,
                                                      ", must be in [-1, ",
                                                      procgen_client::kNumThreadsMax, "]"));
  }
  auto created = procgen_client::LocalPool::Create(
      *pool_options, options.num_threads == -1 ? std::optional<int32_t>() : options.num_threads);
  if (!created.ok()) {
    return created.status();
  }
  *pool = new ProcgenPool{.pool = *std::move(created)};
  return procgen::OkStatus();
}

// Sends a request, or executes it at once.
enum class Way { kSend, kWait };

procgen::Status Request(procgen_client::Pool& pool, Way way, const procgen::StepInput& input,
                        absl::Span<const procgen_client::Annotation> annotations,
                        const ProcgenBatch* given) {
  if (procgen::Status status = CheckStruct(given, "batch"); !status.ok()) {
    return status;
  }
  const procgen::Batch batch =
      BatchOf(*given, input.count, pool.options().observation_format.bytes());
  return way == Way::kSend ? pool.Send(input, annotations, batch)
                           : pool.Step(input, annotations, batch);
}

ProcgenCode Step(ProcgenPool* handle, Way way, const ProcgenStep* given,
                 const ProcgenBatch* batch) noexcept {
  return GuardPool(handle, [&](procgen_client::Pool& pool) -> procgen::Status {
    if (procgen::Status status = CheckStruct(given, "step"); !status.ok()) {
      return status;
    }
    const ProcgenStep step = Complete(*given);
    if (procgen::Status status = FirstError(
            {CheckArray(step.next_levels, "next_levels", step.next_level_count, "next_level_count"),
             CheckArray(step.resets, "resets", step.reset_count, "reset_count"),
             CheckArray(step.annotations, "annotations", step.annotation_count,
                        "annotation_count")});
        !status.ok()) {
      return status;
    }
    const auto annotations = procgen_client::AnnotationsOf(step);
    if (!annotations.ok()) {
      return annotations.status();
    }
    const std::vector<procgen::NextLevel> next_levels =
        procgen_client::NextLevelsOf(step.next_levels, step.next_level_count);
    const std::vector<procgen::Reset> resets = ResetsOf(step.resets, step.reset_count);
    return Request(pool, way, StepInputOf(step, next_levels, resets), *annotations, batch);
  });
}

ProcgenCode Reset(ProcgenPool* handle, Way way, int32_t first_env, int32_t env_count,
                  const ProcgenReset* given, int32_t reset_count,
                  const ProcgenBatch* batch) noexcept {
  return GuardPool(handle, [&](procgen_client::Pool& pool) -> procgen::Status {
    if (procgen::Status status = CheckArray(given, "resets", reset_count, "reset_count");
        !status.ok()) {
      return status;
    }
    const std::vector<procgen::Reset> resets = ResetsOf(given, reset_count);
    if (resets.empty()) {
      return procgen::InvalidArgumentError("resets is empty, must name at least one environment");
    }
    return Request(pool, way,
                   {.first = first_env, .count = env_count, .steps = false, .resets = resets},
                   /*annotations=*/{}, batch);
  });
}

ProcgenCode Observe(ProcgenPool* handle, Way way, int32_t first_env, int32_t env_count,
                    const ProcgenBatch* batch) noexcept {
  return GuardPool(handle, [&](procgen_client::Pool& pool) {
    return Request(pool, way, {.first = first_env, .count = env_count, .steps = false},
                   /*annotations=*/{}, batch);
  });
}

}  // namespace

int32_t procgen_abi_version(void) { return PROCGEN_ABI_VERSION; }

const char* procgen_version(void) { return PROCGEN_VERSION; }

const char* procgen_error_message(void) { return procgen_client::ErrorMessage().c_str(); }

const char* procgen_catalog_json(void) {
  static const std::string json = procgen_client::CatalogJson();
  return json.c_str();
}

void procgen_pool_options_init(ProcgenPoolOptions* options, size_t struct_size) {
  procgen_client::SetDefaults(options, struct_size);
}

ProcgenCode procgen_pool_create(const ProcgenPoolOptions* options, ProcgenPool** pool) {
  return Guard([&]() -> procgen::Status {
    if (procgen::Status status =
            FirstError({CheckStruct(options, "options"), CheckNotNull(pool, "pool")});
        !status.ok()) {
      return status;
    }
    return Create(*options, pool);
  });
}

void procgen_pool_destroy(ProcgenPool* pool) {
  if (pool != nullptr && !pool->owner.is_this_process()) {
    return;  // Its threads are not in this process, so they cannot be joined.
  }
  delete pool;
}

ProcgenCode procgen_pool_info(const ProcgenPool* pool, ProcgenPoolInfo* info) {
  return GuardPool(pool, [&](const procgen_client::Pool& of) {
    if (procgen::Status status = CheckStruct(info, "info"); !status.ok()) {
      return status;
    }
    procgen_client::Fill(of.options(), of.thread_count(), info);
    return procgen::OkStatus();
  });
}

ProcgenCode procgen_step(ProcgenPool* pool, const ProcgenStep* step, const ProcgenBatch* batch) {
  return Step(pool, Way::kWait, step, batch);
}

ProcgenCode procgen_reset(ProcgenPool* pool, int32_t first_env, int32_t env_count,
                          const ProcgenReset* resets, int32_t reset_count,
                          const ProcgenBatch* batch) {
  return Reset(pool, Way::kWait, first_env, env_count, resets, reset_count, batch);
}

ProcgenCode procgen_observe(ProcgenPool* pool, int32_t first_env, int32_t env_count,
                            const ProcgenBatch* batch) {
  return Observe(pool, Way::kWait, first_env, env_count, batch);
}

ProcgenCode procgen_send_step(ProcgenPool* pool, const ProcgenStep* step,
                              const ProcgenBatch* batch) {
  return Step(pool, Way::kSend, step, batch);
}

ProcgenCode procgen_send_reset(ProcgenPool* pool, int32_t first_env, int32_t env_count,
                               const ProcgenReset* resets, int32_t reset_count,
                               const ProcgenBatch* batch) {
  return Reset(pool, Way::kSend, first_env, env_count, resets, reset_count, batch);
}

ProcgenCode procgen_send_observe(ProcgenPool* pool, int32_t first_env, int32_t env_count,
                                 const ProcgenBatch* batch) {
  return Observe(pool, Way::kSend, first_env, env_count, batch);
}

ProcgenCode procgen_receive(ProcgenPool* pool, double timeout_s) {
  return GuardPool(pool, [&](procgen_client::Pool& of) {
    return of.Receive(std::chrono::duration<double>(timeout_s));
  });
}

int32_t procgen_unanswered_count(const ProcgenPool* pool) {
  return pool == nullptr ? 0 : pool->pool->unanswered_count();
}

ProcgenCode procgen_set_level_sampler(ProcgenPool* pool, const ProcgenLevelSampler* sampler) {
  return GuardPool(pool, [&](procgen_client::Pool& of) {
    if (procgen::Status status = CheckStruct(sampler, "sampler"); !status.ok()) {
      return status;
    }
    auto level_sampler = procgen_client::LevelSamplerOf(*sampler);
    return level_sampler.ok() ? of.SetLevelSampler(*std::move(level_sampler))
                              : level_sampler.status();
  });
}

ProcgenCode procgen_save_states(ProcgenPool* pool, const int32_t* environments, int32_t count,
                                uint8_t* data, size_t capacity, size_t* offsets) {
  return GuardPool(pool, [&](procgen_client::Pool& of) {
    if (procgen::Status status =
            FirstError({CheckArray(environments, "environments", count, "count"),
                        CheckArray(data, "data", static_cast<int64_t>(capacity), "capacity"),
                        CheckNotNull(offsets, "offsets")});
        !status.ok()) {
      return status;
    }
    const auto states = of.SaveStates(procgen_client::SpanOf(environments, count));
    if (!states.ok()) {
      return states.status();
    }
    offsets[0] = 0;
    for (size_t i = 0; i < states->size(); ++i) {
      offsets[i + 1] = offsets[i] + (*states)[i].size();
    }
    if (offsets[states->size()] > capacity) {
      return procgen::ResourceExhaustedError(absl::StrCat(
          "capacity is ", capacity, " bytes, the states have ", offsets[states->size()]));
    }
    for (size_t i = 0; i < states->size(); ++i) {
      std::copy((*states)[i].begin(), (*states)[i].end(), data + offsets[i]);
    }
    return procgen::OkStatus();
  });
}

ProcgenCode procgen_restore_states(ProcgenPool* pool, const int32_t* environments, int32_t count,
                                   const uint8_t* data, const size_t* offsets) {
  return GuardPool(pool, [&](procgen_client::Pool& of) {
    if (procgen::Status status =
            FirstError({CheckArray(environments, "environments", count, "count"),
                        CheckNotNull(data, "data"), CheckNotNull(offsets, "offsets")});
        !status.ok()) {
      return status;
    }
    std::vector<procgen::StateToRestore> states;
    const absl::Span<const int32_t> targets = procgen_client::SpanOf(environments, count);
    for (size_t i = 0; i < targets.size(); ++i) {
      if (offsets[i] > offsets[i + 1]) {
        return procgen::InvalidArgumentError(
            absl::StrCat("offsets[", i + 1, "] is ", offsets[i + 1], ", less than the one before, ",
                         offsets[i]));
      }
      const auto* const begin = reinterpret_cast<const char*>(data) + offsets[i];
      states.push_back({.environment = targets[i],
                        .snapshot = absl::string_view(begin, offsets[i + 1] - offsets[i])});
    }
    return of.RestoreStates(states);
  });
}

ProcgenCode procgen_clone_states(ProcgenPool* pool, const int32_t* sources, const int32_t* targets,
                                 int32_t count) {
  return GuardPool(pool, [&](procgen_client::Pool& of) {
    if (procgen::Status status = FirstError({CheckArray(sources, "sources", count, "count"),
                                             CheckArray(targets, "targets", count, "count")});
        !status.ok()) {
      return status;
    }
    std::vector<procgen::StateToClone> pairs;
    pairs.reserve(static_cast<size_t>(count));
    for (int32_t i = 0; i < count; ++i) {
      pairs.push_back({.source_environment = sources[i], .target_environment = targets[i]});
    }
    return of.CloneStates(pairs);
  });
}

ProcgenCode procgen_render(ProcgenPool* pool, int32_t environment, int32_t size_px,
                           uint8_t whole_level, uint8_t* frame) {
  return GuardPool(pool, [&](procgen_client::Pool& of) {
    if (procgen::Status status = CheckNotNull(frame, "frame"); !status.ok()) {
      return status;
    }
    const auto side = static_cast<size_t>(std::max(size_px, 0));
    return of.Render(environment, size_px, whole_level != 0,
                     absl::MakeSpan(frame, side * side * 3));
  });
}
