#include "server/fleet/pool/fleet_pool.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "server/fleet/log/shard_request.h"
#include "server/fleet/pool/answer_rows.h"

namespace procgen {

FleetPool::FleetPool(const PoolOptions& options, StateValidator validator,
                     const ShardContext& context, BackgroundExecutor* executor,
                     std::function<void(FleetPool*)> goes)
    : options_(options),
      validator_(std::move(validator)),
      log_(options.env_count, options.observation_format.frame_stack, context.label,
           context.options->log_bytes_max),
      context_([&] {
        auto own = std::make_shared<ShardContext>(context);
        own->log = &log_;
        own->observation_bytes = options.observation_format.bytes();
        return own;
      }()),
      executor_(executor),
      goes_(std::move(goes)),
      awaits_reset_(static_cast<size_t>(options.env_count)),
      shards_(context_),
      rebalancer_(context_, options.env_count, &shards_, executor) {
  if (options.level_sampler != nullptr) {
    sampler_ =
        std::make_shared<const v1::LevelSampler>(LevelSamplerMessageOf(*options.level_sampler));
  }
}

FleetPool::~FleetPool() { goes_(this); }

void FleetPool::Begin(const std::vector<ShardAssignment>& assignments,
                      std::vector<ShardThreadBudget::Reservation> threads, Done done) {
  auto made = shards_.Make(SplitCheckpoint({0, {}, sampler_}, assignments), assignments,
                           std::move(threads));
  if (!made.ok()) {
    done(made.status());
    return;
  }
  shards_.Replace(*std::move(made));
  ShardSet::Run(shards_.all(), 0, std::move(done));
}

absl::Status FleetPool::KeepIn(const std::string& path, const v1::Pool& pool) {
  JournaledPool journaled;
  journaled.pool = pool;
  journaled.checkpoints = shards_.checkpoints();
  return log_.Keep(path, std::move(journaled), context_->metrics);
}

absl::StatusOr<std::vector<v1::StepPoolRequest>> FleetPool::Resume(const std::string& path,
                                                                   const JournaledPool& journaled,
                                                                   int64_t answer_count) {
  log_.Resume(path, journaled, context_->metrics);
  int64_t latest = 0;  // checkpoint; later entries may have replaced the sampler
  for (const auto& [first, checkpoint] : journaled.checkpoints) {
    if (checkpoint.second->number >= latest) {
      latest = checkpoint.second->number;
      sampler_ = checkpoint.second->sampler;
    }
  }
  again_number_ = latest;
  std::vector<v1::StepPoolRequest> requests;
  for (int64_t number = latest + 1; number <= log_.requests().end(); ++number) {
    const RequestLog::Entry entry = log_.requests().Find(number);
    if (entry->request.has_level_sampler()) {
      sampler_ = {entry, &entry->request.level_sampler()};
    }
    if (entry->request.sequence_number() > 0) {
      requests.push_back(entry->request);
    }
  }
  const auto count = static_cast<int64_t>(requests.size());
  requests.erase(requests.begin(), requests.begin() + std::max<int64_t>(0, count - answer_count));
  auto shards = shards_.Make(journaled.checkpoints, {});
  if (!shards.ok()) {
    return shards.status();
  }
  shards_.Replace(*std::move(shards));
  return requests;
}

void FleetPool::BeginRequest(const Request& request, const Batch& first_part) {
  ForgetLog();
  number_ = log_.requests().end() + 1;
  is_logged_ = !request.again;
  progress_.Begin({request.first, request.count});
  if (request.again) {
    number_ = again_number_ + 1;
    while (log_.requests().Find(number_)->request.sequence_number() != request.sequence_number) {
      ++number_;  // states, or a request that no learner can ask for again
    }
    again_number_ = number_ - 1;  // until it is executed
    RunRequest(number_);
    return;
  }
  const bool steps_all = request.kind == Request::Kind::kStep && request.count == env_count();
  if (absl::Status status = log_.CheckRoom(/*may_shorten=*/steps_all); !status.ok()) {
    is_logged_ = false;
    progress_.Start({}, std::move(status));
    return;
  }
  log_.Append({RequestMessageOf(request, first_part), {}});
  rebalancer_.BeforeRequest(number_, sampler_, [this, number = number_] { RunRequest(number); });
}

void FleetPool::RunRequest(int64_t number) {
  const RequestLog::Entry logged = log_.requests().Find(number);
  if (logged->request.has_level_sampler()) {
    sampler_ = {logged, &logged->request.level_sampler()};
  }
  // Occasionally all shards run, so that none needs old log entries.
  const bool all = logged->request.has_level_sampler() ||
                   number % std::max<int64_t>(context_->options->snapshot_requests, 1) == 0;
  const std::vector<Shard*> shards =
      all ? shards_.all() : shards_.Overlapping(SliceOf(logged->request, env_count()));
  std::vector<Part> ranges;
  ranges.reserve(shards.size());
  for (const Shard* shard : shards) {
    ranges.push_back(shard->range());
  }
  progress_.Start(std::move(ranges));
  for (Shard* const shard : shards) {
    shard->Run(number, [this, range = shard->range()](const absl::Status& status) {
      AnswerPart(progress_.OnShardDone(range, status));
    });
  }
}

void FleetPool::AnswerPart(std::optional<RequestProgress::Answer> answer) {
  if (!answer.has_value()) {
    return;
  }
  if (answer->status.ok()) {
    for (const Shard* shard : shards_.Overlapping(answer->part)) {
      CopyRows(*shard, answer->part, answer->batch);
    }
  } else {
    shards_.Rollback(number_ - 1);
    if (is_logged_) {
      log_.RemoveLast();
    }
    rebalancer_.DiscardCheckpoint();
  }
  answer->done(std::move(answer->status));
}

void FleetPool::StepAsync(const StepInput& part, const Batch& batch, Done done) {
  AnswerPart(progress_.AddPart({part.first, part.count}, batch, std::move(done)));
}

void FleetPool::SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) {
  // BeginRequest has logged it.
  StepAsync({}, {},
            [this, sampler = std::move(level_sampler),
             done = std::move(done)](absl::Status status) mutable {
              if (status.ok()) {
                held_sampler_ = std::move(sampler);
              }
              done(std::move(status));
            });
}

void FleetPool::CopyRows(const Shard& shard, Part part, const Batch& batch) {
  const Part rows = Overlap(part, shard.range());
  const procgen_client::Batch& answer = shard.answer();
  const auto count = static_cast<size_t>(rows.count);
  const auto from = static_cast<size_t>(rows.first - shard.range().first - answer.first_env());
  CopyAnswerRows(answer, from, batch, static_cast<size_t>(rows.first - part.first), count,
                 context_->observation_bytes);
  for (size_t i = 0; i < count; ++i) {
    const bool ended = answer.terminated()[from + i] || answer.truncated()[from + i];
    awaits_reset_[static_cast<size_t>(rows.first) + i] =
        ended && options_.autoreset_mode == AutoresetMode::kDisabled;
  }
}

void FleetPool::ForgetLog() {
  log_.ForgetUpTo(std::min(shards_.checkpoint_number(), rebalancer_.checkpoint_number()));
}

void FleetPool::SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) {
  for (const int32_t environment : environments) {
    if (absl::Status status = CheckEnvironment(environment, env_count()); !status.ok()) {
      done(std::move(status));
      return;
    }
  }
  auto shared_take = std::make_shared<TakeState>(std::move(take));
  auto shared_done = std::make_shared<Done>(std::move(done));
  shards_.Save(
      {environments.begin(), environments.end()},
      [environments, shared_take, shared_done](absl::StatusOr<std::vector<std::string>> snapshots) {
        if (snapshots.ok()) {
          for (size_t i = 0; i < environments.size(); ++i) {
            if (!(*shared_take)(environments[i], std::move((*snapshots)[i]))) {
              break;
            }
          }
        }
        (*shared_done)(snapshots.status());
      });
}

void FleetPool::ApplyStates(std::vector<v1::State> states, const std::shared_ptr<Done>& done) {
  const std::vector<bool> awaited_reset = awaits_reset_;
  if (absl::Status status = validator_.Check(states, &awaits_reset_);
      !status.ok() || states.empty()) {
    (*done)(std::move(status));
    return;
  }
  ForgetLog();
  if (absl::Status status = log_.CheckRoom(/*may_shorten=*/false); !status.ok()) {
    awaits_reset_ = awaited_reset;
    (*done)(std::move(status));
    return;
  }
  std::vector<int32_t> environments;
  environments.reserve(states.size());
  for (const v1::State& state : states) {
    environments.push_back(state.environment());
  }
  const int64_t number = log_.Append({{}, std::move(states)});
  ShardSet::Run(shards_.Containing(environments), number,
                [this, number, awaited_reset, done](absl::Status status) {
                  if (!status.ok()) {
                    shards_.Rollback(number - 1);
                    log_.RemoveLast();
                    awaits_reset_ = awaited_reset;
                  }
                  (*done)(std::move(status));
                });
}

void FleetPool::RestoreStates(std::vector<StateToRestore> states, Done done) {
  executor_->Run(context_->owner, [this, states = std::move(states),
                                   done = std::make_shared<Done>(std::move(done))] {
    std::vector<v1::State> messages;
    for (const StateToRestore& state : states) {
      messages.emplace_back();
      messages.back().set_environment(state.environment);
      messages.back().set_snapshot(std::string(state.snapshot));
    }
    ApplyStates(std::move(messages), done);
  });
}

void FleetPool::CloneStates(std::vector<StateToClone> pairs, Done done) {
  // A source may be used several times, but is requested once.
  std::map<int32_t, size_t> places;
  std::vector<int32_t> sources;
  for (const StateToClone& pair : pairs) {
    const int32_t source = pair.source_environment;
    if (absl::Status status = CheckEnvironment(source, env_count()); !status.ok()) {
      done(std::move(status));
      return;
    }
    if (places.emplace(source, sources.size()).second) {
      sources.push_back(source);
    }
  }
  shards_.Save(sources, [this, pairs = std::move(pairs), places = std::move(places),
                         done = std::make_shared<Done>(std::move(done))](
                            absl::StatusOr<std::vector<std::string>> snapshots) {
    if (!snapshots.ok()) {
      (*done)(snapshots.status());
      return;
    }
    std::vector<v1::State> states;
    for (const StateToClone& pair : pairs) {
      states.emplace_back();
      states.back().set_environment(pair.target_environment);
      states.back().set_snapshot((*snapshots)[places.at(pair.source_environment)]);
    }
    executor_->Run(context_->owner,
                   [this, states = std::move(states), done] { ApplyStates(states, done); });
  });
}

void FleetPool::CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                              CaptureDone done) {
  const size_t frame_bytes = static_cast<size_t>(size_px) * static_cast<size_t>(size_px) * 3;
  auto drawn = std::make_shared<std::vector<uint8_t>>(environments.size() * frame_bytes);
  std::vector<absl::Span<uint8_t>> frames;
  for (size_t i = 0; i < environments.size(); ++i) {
    frames.push_back(absl::MakeSpan(*drawn).subspan(i * frame_bytes, frame_bytes));
  }
  shards_.Render(environments, view, size_px, frames,
                 [drawn, frame_bytes, done = std::move(done)](const absl::Status& status) mutable {
                   if (!status.ok()) {
                     done(status);
                     return;
                   }
                   done(Draw([drawn, frame_bytes](const std::vector<absl::Span<uint8_t>>& wanted) {
                     for (size_t i = 0; i < wanted.size(); ++i) {
                       std::memcpy(wanted[i].data(), drawn->data() + i * frame_bytes, frame_bytes);
                     }
                   }));
                 });
}

}  // namespace procgen
