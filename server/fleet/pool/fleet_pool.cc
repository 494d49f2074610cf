#include "server/fleet/pool/fleet_pool.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "envcore/pool/pool_input.h"
#include "server/fleet/log/shard_request.h"

namespace procgen {
namespace {

template <typename Element, typename Source>
void CopySpan(absl::Span<const Source> from, size_t from_row, absl::Span<Element> to, size_t to_row,
              size_t rows, size_t row_size = 1) {
  static_assert(sizeof(Element) == sizeof(Source));
  if (!to.empty() && !from.empty()) {
    std::memcpy(to.data() + to_row * row_size, from.data() + from_row * row_size,
                rows * row_size * sizeof(Element));
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<Pool>> FleetPool::Check(const PoolOptions& options) {
  if (absl::Status status = CheckPoolOptions(options); !status.ok()) {
    return status;
  }
  PoolOptions model = options;
  model.env_count = static_cast<int32_t>(options.games.size());
  model.first_env = 0;
  model.total_env_count = 0;
  model.observation_format = {};
  return Pool::Create(model, std::make_shared<WorkerPool>(0));
}

FleetPool::FleetPool(const PoolOptions& options, std::unique_ptr<Pool> model,
                     const ShardTerms& terms, BackgroundExecutor* executor,
                     std::function<void(FleetPool*)> goes)
    : options_(options),
      model_(std::move(model)),
      terms_([&] {
        auto own = std::make_shared<ShardTerms>(terms);
        own->log = &log_;
        own->observation_bytes = options.observation_format.bytes();
        own->on_base = [this](Part range, std::shared_ptr<const ShardBase> base) {
          if (journal_ != nullptr) {
            journal_->SetBase(range, std::move(base));
          }
        };
        return own;
      }()),
      executor_(executor),
      goes_(std::move(goes)),
      log_(options.env_count, options.observation_format.frame_stack),
      awaits_reset_(static_cast<size_t>(options.env_count)) {
  if (options.level_sampler != nullptr) {
    sampler_ =
        std::make_shared<const v1::LevelSampler>(LevelSamplerMessageOf(*options.level_sampler));
  }
}

FleetPool::~FleetPool() { goes_(this); }

absl::Status FleetPool::KeepIn(const std::string& path, const v1::Pool& pool) {
  JournaledPool journaled;
  journaled.pool = pool;
  for (const std::unique_ptr<Shard>& shard : shards_) {
    journaled.bases[shard->range().first] = {shard->range(), shard->base()};
  }
  auto journal = Journal::Create(path, std::move(journaled), terms_->metrics);
  if (!journal.ok()) {
    return journal.status();
  }
  journal_ = *std::move(journal);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<v1::StepPoolRequest>> FleetPool::Resume(const std::string& path,
                                                                   const JournaledPool& journaled,
                                                                   int64_t answer_count) {
  journal_ = Journal::Resume(path, journaled, terms_->metrics);
  int64_t latest = 0;  // base; what comes after it may have replaced the sampler
  for (const auto& [first, base] : journaled.bases) {
    if (base.second->number >= latest) {
      latest = base.second->number;
      sampler_ = base.second->sampler;
    }
  }
  log_.BeginAfter(journaled.log_begin);
  again_number_ = latest;
  std::vector<v1::StepPoolRequest> requests;
  for (const RequestLog::Entry& entry : journaled.log) {
    const int64_t number = log_.Append(entry);
    if (entry->request.has_level_sampler() && number > latest) {
      sampler_ = {entry, &entry->request.level_sampler()};
    }
    if (entry->request.sequence_number() > 0 && number > latest) {
      requests.push_back(entry->request);
    }
  }
  const auto count = static_cast<int64_t>(requests.size());
  requests.erase(requests.begin(), requests.begin() + std::max<int64_t>(0, count - answer_count));
  auto shards = MakeShards(journaled.bases, {});
  if (!shards.ok()) {
    return shards.status();
  }
  SetShards(*std::move(shards));
  return requests;
}

void FleetPool::Discard() {
  if (journal_ != nullptr) {
    journal_->Remove();
  }
}

int64_t FleetPool::Log(LoggedRequest logged) {
  auto entry = std::make_shared<const LoggedRequest>(std::move(logged));
  if (journal_ != nullptr) {
    journal_->Append(entry);
  }
  return log_.Append(std::move(entry));
}

void FleetPool::TakeBackLogged() {
  if (journal_ != nullptr) {
    journal_->TakeBack();
  }
  log_.TakeBack();
}

absl::Status FleetPool::CheckLog(bool may_shorten) const {
  const int64_t bytes = log_.BytesAfter(0);
  const int64_t limit = terms_->options->log_bytes_max;
  if (bytes < limit || (may_shorten && bytes < limit + limit / 8)) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(absl::StrCat(
      "the log of ", terms_->label, " has ", bytes, " bytes, limit log_bytes_max: ", limit,
      "; it becomes shorter when each environment has been stepped ",
      std::max(options_.observation_format.frame_stack, 1),
      " times, and its state can be saved: step all environments, or make another pool"));
}

size_t FleetPool::ShardOf(int32_t environment) const {
  size_t index = 0;
  while (environment >= shards_[index]->range().first + shards_[index]->range().count) {
    ++index;
  }
  return index;
}

void FleetPool::BeginRequest(const Request& request, const Batch& first_part) {
  ForgetLog();
  int64_t number = log_.end() + 1;
  const absl::Status status = request.again ? absl::OkStatus()
                                            : CheckLog(request.kind == Request::Kind::kStep &&
                                                       request.count == env_count());
  if (request.again) {
    number = again_number_ + 1;
    while (log_.Find(number)->request.sequence_number() != request.sequence_number) {
      ++number;  // states, or what nobody can ask for again
    }
    again_number_ = number - 1;  // until it is done
  } else if (status.ok()) {
    Log({RequestMessageOf(request, first_part), {}});
  }
  {
    absl::MutexLock lock(&mutex_);
    request_ = {request.first, request.count};
    status_ = status;
    is_logged_ = !request.again && status.ok();
    number_ = number;
    progress_.assign(shards_.size(), Progress::kRunning);
    is_running_ = !status.ok();  // or else no part is answered before shards have begun
  }
  if (!status.ok()) {
    return;
  }
  if (!request.again && divides_.exchange(false) && !division_.has_value()) {
    BeginDivision(number);
  } else if (!request.again && CanDivide(number)) {
    executor_->Run(terms_->owner, [this, number] {
      Divide(*division_->base);
      division_.reset();
      RunRequest(number);
    });
  } else {
    RunRequest(number);
  }
}

void FleetPool::RunRequest(int64_t number) {
  const RequestLog::Entry logged = log_.Find(number);
  if (logged->request.has_level_sampler()) {
    sampler_ = {logged, &logged->request.level_sampler()};
  }
  const Part slice = SliceOf(logged->request, env_count());
  // Now and then all of them, so that none needs the log of long ago.
  const bool all = logged->request.has_level_sampler() ||
                   number % std::max<int64_t>(terms_->options->snapshot_requests, 1) == 0;
  RunShards(number, [all, slice](const Shard& shard) {
    return all || Overlap(slice, shard.range()).count > 0;
  });
}

void FleetPool::RunShards(int64_t number, const std::function<bool(const Shard&)>& concerns) {
  std::vector<size_t> concerned;
  {
    absl::MutexLock lock(&mutex_);
    progress_.resize(shards_.size());
    for (size_t i = 0; i < shards_.size(); ++i) {
      const bool runs = concerns(*shards_[i]);
      progress_[i] = runs ? Progress::kRunning : Progress::kUntouched;
      if (runs) {
        concerned.push_back(i);
      }
    }
    running_count_ = static_cast<int32_t>(concerned.size());
    is_running_ = true;
  }
  for (const size_t i : concerned) {
    shards_[i]->Run(number, [this, i](const absl::Status& status) { OnShardDone(i, status); });
  }
}

void FleetPool::OnShardDone(size_t shard, const absl::Status& status) {
  {
    absl::MutexLock lock(&mutex_);
    progress_[shard] = Progress::kDone;
    --running_count_;
    status_.Update(status);
  }
  AnswerPart();
}

bool FleetPool::CanAnswerLocked() const {
  if (part_done_ == nullptr || !is_running_) {
    return false;
  }
  const bool is_last = part_.first + part_.count == request_.first + request_.count;
  if (!status_.ok() || is_last) {
    return running_count_ == 0;
  }
  for (size_t i = 0; i < shards_.size(); ++i) {
    if (progress_[i] == Progress::kRunning && Overlap(part_, shards_[i]->range()).count > 0) {
      return false;
    }
  }
  return true;
}

void FleetPool::AnswerPart() {
  Done done;
  Part part;
  Batch batch;
  absl::Status status;
  int64_t number = 0;
  bool is_logged = false;
  {
    absl::MutexLock lock(&mutex_);
    if (!CanAnswerLocked()) {
      return;
    }
    done = std::exchange(part_done_, nullptr);
    part = part_;
    batch = batch_;
    status = status_;
    number = number_;
    is_logged = is_logged_;
  }
  if (status.ok()) {
    for (const std::unique_ptr<Shard>& shard : shards_) {
      CopyRows(*shard, part, batch);
    }
  } else {
    for (const std::unique_ptr<Shard>& shard : shards_) {
      shard->Forget(number - 1);
    }
    if (is_logged) {
      TakeBackLogged();
    }
    division_.reset();
  }
  done(std::move(status));
}

void FleetPool::StepAsync(const StepInput& part, const Batch& batch, Done done) {
  {
    absl::MutexLock lock(&mutex_);
    part_ = {part.first, part.count};
    batch_ = batch;
    part_done_ = std::move(done);
  }
  AnswerPart();
}

void FleetPool::SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) {
  // BeginRequest has it in the log.
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
  if (rows.count == 0) {
    return;
  }
  const procgen_client::Batch& answer = shard.answer();
  const auto count = static_cast<size_t>(rows.count);
  const auto to = static_cast<size_t>(rows.first - part.first);
  const auto from = static_cast<size_t>(rows.first - shard.range().first - answer.first_env());
  const size_t picture_bytes = options_.observation_format.bytes();
  CopySpan(answer.observations(), from, batch.observations, to, count, picture_bytes);
  CopySpan(answer.rewards(), from, batch.rewards, to, count);
  CopySpan(answer.first(), from, batch.first, to, count);
  CopySpan(answer.terminated(), from, batch.terminated, to, count);
  CopySpan(answer.truncated(), from, batch.truncated, to, count);
  CopySpan(answer.level_seeds(), from, batch.level_seeds, to, count);
  CopySpan(answer.prev_level_seeds(), from, batch.prev_level_seeds, to, count);
  CopySpan(answer.prev_level_complete(), from, batch.prev_level_complete, to, count);
  CopySpan(answer.episode_returns(), from, batch.episode_returns, to, count);
  CopySpan(answer.episode_lengths(), from, batch.episode_lengths, to, count);
  // Rows of ended episodes come one directly after the other.
  size_t ended_count = 0;
  for (size_t row = 0; row < from + count; ++row) {
    const bool ended = answer.terminated()[row] || answer.truncated()[row];
    if (row >= from) {
      const size_t at = to + row - from;
      awaits_reset_[static_cast<size_t>(part.first) + at] =
          ended && options_.autoreset_mode == AutoresetMode::kDisabled;
      if (ended) {
        CopySpan(answer.fingerprints(), ended_count, batch.fingerprints, at, 1);
        CopySpan(answer.final_observations(), ended_count, batch.final_observations, at, 1,
                 picture_bytes);
      }
    }
    ended_count += ended ? 1 : 0;
  }
}

void FleetPool::ForgetLog() {
  int64_t needed = shards_.front()->base_number();
  for (const std::unique_ptr<Shard>& shard : shards_) {
    needed = std::min(needed, shard->base_number());
  }
  if (division_.has_value()) {
    needed = std::min(needed, division_->base->number);
  }
  log_.ForgetUpTo(needed);
}

}  // namespace procgen
