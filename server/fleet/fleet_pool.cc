#include "server/fleet/fleet_pool.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "envcore/pool/pool_input.h"
#include "server/fleet/shard_request.h"
#include "server/session/event_log.h"

namespace procgen {
namespace {

// Another division is worth it where so large a part of the environments would move.
constexpr double kWorthMoving = 0.15;
constexpr int32_t kLooksBeforeDividing = 2;

Part Overlap(Part left, Part right) {
  const int32_t first = std::max(left.first, right.first);
  const int32_t end = std::min(left.first + left.count, right.first + right.count);
  return {first, std::max(0, end - first)};
}

// Shards of these shares, which all begin with `base`, that of the whole pool.
ShardBases BasesOf(const std::vector<FleetNodes::Share>& shares, const ShardBase& base) {
  ShardBases bases;
  Part range;
  for (const FleetNodes::Share& share : shares) {
    range = {range.first + range.count, share.env_count};
    ShardBase own = {base.number, {}, base.sampler};
    if (!base.states.empty()) {
      const auto first = base.states.begin() + range.first;
      own.states.assign(first, first + range.count);
    }
    bases[range.first] = {range, std::make_shared<const ShardBase>(std::move(own))};
  }
  return bases;
}

std::vector<std::string> NodesOf(const std::vector<FleetNodes::Share>& shares) {
  std::vector<std::string> nodes;
  for (const FleetNodes::Share& share : shares) {
    nodes.push_back(share.node_id);
  }
  return nodes;
}

// Waits for several that are done at their own times, and then calls `done` with the first error.
class Countdown {
 public:
  Countdown(size_t count, HostedPool::Done done) : left_(count), done_(std::move(done)) {}

  void Count(const absl::Status& status) {
    bool is_last = false;
    absl::Status result;
    {
      absl::MutexLock lock(&mutex_);
      status_.Update(status);
      is_last = --left_ == 0;
      result = status_;
    }
    if (is_last) {
      done_(std::move(result));
    }
  }

 private:
  absl::Mutex mutex_;
  size_t left_ ABSL_GUARDED_BY(mutex_);
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  HostedPool::Done done_;
};

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
  model.first_environment = 0;
  model.total_environments = 0;
  model.observation_format = {};
  return Pool::Create(model, std::make_shared<Crew>(0));
}

FleetPool::FleetPool(const PoolOptions& options, std::unique_ptr<Pool> model,
                     const ShardTerms& terms, SideCrew* side_crew,
                     std::function<void(FleetPool*)> goes)
    : options_(options),
      model_(std::move(model)),
      terms_([&] {
        auto own = std::make_shared<ShardTerms>(terms);
        own->log = &log_;
        own->on_base = [this](Part range, std::shared_ptr<const ShardBase> base) {
          if (journal_ != nullptr) {
            journal_->SetBase(range, std::move(base));
          }
        };
        return own;
      }()),
      side_crew_(side_crew),
      goes_(std::move(goes)),
      awaits_reset_(static_cast<size_t>(options.env_count)) {
  if (options.level_sampler != nullptr) {
    sampler_ =
        std::make_shared<const v1::LevelSampler>(LevelSamplerMessageOf(*options.level_sampler));
  }
}

FleetPool::~FleetPool() { goes_(this); }

void FleetPool::Begin(const std::vector<FleetNodes::Share>& shares, Done done) {
  MakeShards(BasesOf(shares, {0, {}, sampler_}), NodesOf(shares));
  auto countdown = std::make_shared<Countdown>(shards_.size(), std::move(done));
  for (const std::unique_ptr<Shard>& shard : shards_) {
    shard->Run(0, [countdown](const absl::Status& status) { countdown->Count(status); });
  }
}

absl::Status FleetPool::KeepIn(const std::string& path, const v1::Pool& pool) {
  JournaledPool journaled;
  journaled.pool = pool;
  for (const std::unique_ptr<Shard>& shard : shards_) {
    journaled.bases[shard->range().first] = {shard->range(), shard->base()};
  }
  auto journal = Journal::Create(path, journaled);
  if (!journal.ok()) {
    return journal.status();
  }
  journal_ = *std::move(journal);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<v1::StepPoolRequest>> FleetPool::Resume(const std::string& path,
                                                                   const JournaledPool& journaled,
                                                                   int64_t answer_count) {
  auto journal = Journal::Create(path, journaled);
  if (!journal.ok()) {
    return journal.status();
  }
  journal_ = *std::move(journal);
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
  for (const LoggedRequest& logged : journaled.log) {
    const int64_t number = log_.Append(logged);
    const RequestLog::Entry entry = log_.Find(number);
    if (entry->request.has_level_sampler() && number > latest) {
      sampler_ = {entry, &entry->request.level_sampler()};
    }
    if (entry->request.sequence_number() > 0 && number > latest) {
      requests.push_back(entry->request);
    }
  }
  const auto count = static_cast<int64_t>(requests.size());
  requests.erase(requests.begin(), requests.begin() + std::max<int64_t>(0, count - answer_count));
  MakeShards(journaled.bases, {});
  return requests;
}

void FleetPool::Discard() {
  if (journal_ != nullptr) {
    journal_->Remove();
  }
}

int64_t FleetPool::Log(LoggedRequest logged) {
  if (journal_ != nullptr) {
    journal_->Append(logged);
  }
  return log_.Append(std::move(logged));
}

void FleetPool::TakeBackLogged() {
  if (journal_ != nullptr) {
    journal_->TakeBack();
  }
  log_.TakeBack();
}

void FleetPool::MakeShards(const ShardBases& bases, const std::vector<std::string>& nodes) {
  std::vector<std::unique_ptr<Shard>> shards;
  for (const auto& [first, base] : bases) {
    const std::string node = nodes.empty() ? "" : nodes[shards.size()];
    shards.push_back(
        std::make_unique<Shard>(terms_, ++shard_number_, base.first, base.second, node));
  }
  absl::MutexLock lock(&shards_mutex_);
  shards_ = std::move(shards);
}

void FleetPool::Look() {
  absl::MutexLock lock(&shards_mutex_);
  std::vector<FleetNodes::Share> now;
  for (const std::unique_ptr<Shard>& shard : shards_) {
    shard->Look();
    now.push_back({shard->node_id(), shard->range().count});
  }
  // What nodes tell of themselves may be old, so a single look is not enough.
  looks_worth_dividing_ = IsWorthDividing(now) ? looks_worth_dividing_ + 1 : 0;
  if (looks_worth_dividing_ >= kLooksBeforeDividing) {
    looks_worth_dividing_ = 0;
    divides_ = true;
  }
}

bool FleetPool::IsWorthDividing(const std::vector<FleetNodes::Share>& now) const {
  std::map<std::string, int32_t> counts;
  for (const FleetNodes::Share& share : now) {
    if (!terms_->nodes->IsUsable(share.node_id)) {
      return false;  // a shard is on its way
    }
    counts[share.node_id] += share.env_count;
  }
  const auto better = terms_->nodes->Divide(env_count(), now);
  if (!better.ok()) {
    return false;
  }
  int32_t moving = 0;
  for (const FleetNodes::Share& share : *better) {
    moving += std::max(0, share.env_count - counts[share.node_id]);
  }
  return moving >= kWorthMoving * env_count();
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
  int64_t number = 0;
  if (request.again) {
    number = again_number_ + 1;
    while (log_.Find(number)->request.sequence_number() != request.sequence_number) {
      ++number;  // states, or what nobody can ask for again
    }
    again_number_ = number - 1;  // until it is done
  } else {
    number = Log({RequestMessageOf(request, first_part), {}, 0});
  }
  {
    absl::MutexLock lock(&mutex_);
    request_ = {request.first, request.count};
    status_ = absl::OkStatus();
    is_again_ = request.again;
    number_ = number;
    progress_.assign(shards_.size(), Progress::kRunning);
    running_count_ = 1;  // so that no part is answered before shards have begun
  }
  if (request.again) {
    RunRequest(number);
  } else if (divides_.exchange(false) && !division_.has_value()) {
    BeginDivision(number);
  } else if (CanDivide(number)) {
    side_crew_->Run([this, number] {
      Divide(std::move(division_->base));
      division_.reset();
      RunRequest(number);
    });
  } else {
    RunRequest(number);
  }
}

void FleetPool::BeginDivision(int64_t number) {
  std::vector<int32_t> all(static_cast<size_t>(env_count()));
  std::iota(all.begin(), all.end(), 0);
  Gather(std::move(all), [this, number](absl::StatusOr<std::vector<std::string>> states) {
    // Not on the thread of a shard, which may have to go.
    side_crew_->Run([this, number, states = std::move(states)]() mutable {
      if (states.ok()) {
        ShardBase base = {number - 1, *std::move(states), sampler_};
        PictureCount pictures({0, env_count()}, options_.observation_format.frame_stack);
        division_ = Division{std::move(base), std::move(pictures)};
      }
      if (CanDivide(number)) {
        Divide(std::move(division_->base));
        division_.reset();
      }
      RunRequest(number);
    });
  });
}

bool FleetPool::CanDivide(int64_t number) const {
  return division_.has_value() && division_->pictures.IsComplete() &&
         number > division_->base.number + terms_->answers_kept;
}

void FleetPool::Divide(ShardBase base) {
  std::vector<FleetNodes::Share> now;
  for (const std::unique_ptr<Shard>& shard : shards_) {
    now.push_back({shard->node_id(), shard->range().count});
  }
  const auto shares = terms_->nodes->Divide(env_count(), now);
  if (!shares.ok()) {
    return;  // nodes have gone in the meantime
  }
  std::vector<std::unique_ptr<Shard>> old;
  {
    absl::MutexLock lock(&shards_mutex_);
    old.swap(shards_);
  }
  old.clear();  // before the others, who need the room
  LogEvent(LogLevel::kInfo, "pool_divided",
           {{"pool", terms_->label},
            {"shards", absl::StrCat(shares->size())},
            {"from", absl::StrCat(base.number)}});
  ShardBases bases = BasesOf(*shares, base);
  MakeShards(bases, NodesOf(*shares));
  if (journal_ != nullptr) {
    journal_->SetBases(std::move(bases));
  }
}

void FleetPool::RunRequest(int64_t number) {
  const RequestLog::Entry logged = log_.Find(number);
  if (logged->request.has_level_sampler()) {
    sampler_ = {logged, &logged->request.level_sampler()};
  }
  const Part slice = SliceOf(logged->request, env_count());
  if (division_.has_value() && logged->request.has_step()) {
    division_->pictures.AddStep(slice);
  }
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
  if (part_done_ == nullptr) {
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
  bool is_again = false;
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
    is_again = is_again_;
  }
  if (status.ok()) {
    for (const std::unique_ptr<Shard>& shard : shards_) {
      CopyRows(*shard, part, batch);
    }
  } else {
    for (const std::unique_ptr<Shard>& shard : shards_) {
      shard->Forget(number - 1);
    }
    if (!is_again) {
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

void FleetPool::SetLevelSampler(std::shared_ptr<const LevelSampler> /*level_sampler*/, Done done) {
  // BeginRequest has it in the log.
  StepAsync({}, {}, std::move(done));
}

void FleetPool::CopyRows(const Shard& shard, Part part, const Batch& batch) {
  const Part rows = Overlap(part, shard.range());
  if (rows.count == 0) {
    return;
  }
  const procgen_client::Batch& answer = shard.answer();
  const auto count = static_cast<size_t>(rows.count);
  const auto to = static_cast<size_t>(rows.first - part.first);
  const auto from =
      static_cast<size_t>(rows.first - shard.range().first - answer.first_environment());
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
          ended && options_.episode_end == EpisodeEnd::kDisabled;
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
    needed = std::min(needed, division_->base.number);
  }
  log_.ForgetUpTo(needed);
}

absl::Status FleetPool::CheckIndex(int32_t environment) const {
  if (environment < 0 || environment >= env_count()) {
    return absl::InvalidArgumentError(
        absl::StrCat("environment ", environment, " is not in [0, ", env_count(), ")"));
  }
  return absl::OkStatus();
}

std::vector<FleetPool::Chosen> FleetPool::Choose(absl::Span<const int32_t> environments) const {
  std::vector<Chosen> chosen(shards_.size());
  for (size_t place = 0; place < environments.size(); ++place) {
    const size_t shard = ShardOf(environments[place]);
    chosen[shard].environments.push_back(environments[place] - shards_[shard]->range().first);
    chosen[shard].places.push_back(place);
  }
  return chosen;
}

void FleetPool::Gather(std::vector<int32_t> environments,
                       std::function<void(absl::StatusOr<std::vector<std::string>>)> done) {
  struct Gathered {
    std::vector<Chosen> chosen;
    std::vector<std::vector<std::string>> by_shard;
    size_t count = 0;
  };
  for (const int32_t environment : environments) {
    if (absl::Status status = CheckIndex(environment); !status.ok()) {
      done(std::move(status));
      return;
    }
  }
  auto gathered = std::make_shared<Gathered>();
  gathered->chosen = Choose(environments);
  gathered->by_shard.resize(shards_.size());
  gathered->count = environments.size();
  const auto finish = [gathered, done = std::move(done)](absl::Status status) {
    if (!status.ok()) {
      done(std::move(status));
      return;
    }
    std::vector<std::string> snapshots(gathered->count);
    for (size_t shard = 0; shard < gathered->chosen.size(); ++shard) {
      for (size_t i = 0; i < gathered->chosen[shard].places.size(); ++i) {
        snapshots[gathered->chosen[shard].places[i]] = std::move(gathered->by_shard[shard][i]);
      }
    }
    done(std::move(snapshots));
  };
  std::vector<size_t> concerned;
  for (size_t i = 0; i < shards_.size(); ++i) {
    if (!gathered->chosen[i].environments.empty()) {
      concerned.push_back(i);
    }
  }
  if (concerned.empty()) {
    finish(absl::OkStatus());
    return;
  }
  auto countdown = std::make_shared<Countdown>(concerned.size(), finish);
  for (const size_t i : concerned) {
    // A node saves each environment once.
    shards_[i]->Save(gathered->chosen[i].environments, &gathered->by_shard[i],
                     [countdown](const absl::Status& status) { countdown->Count(status); });
  }
}

void FleetPool::SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) {
  auto shared_take = std::make_shared<TakeState>(std::move(take));
  auto shared_done = std::make_shared<Done>(std::move(done));
  Gather(
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

absl::Status FleetPool::CheckStates(const std::vector<v1::State>& states) {
  std::set<int32_t> had;
  std::vector<bool> awaits_reset = awaits_reset_;
  for (const v1::State& state : states) {
    const int32_t environment = state.environment();
    if (absl::Status status = CheckIndex(environment); !status.ok()) {
      return status;
    }
    if (!had.insert(environment).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("environment ", environment, " is to be restored twice"));
    }
    const int32_t game = (options_.first_environment + environment) % model_->env_count();
    const absl::Status status = model_->RestoreStates({{game, state.snapshot()}});
    if (!status.ok()) {
      const absl::string_view message =
          absl::StripPrefix(status.message(), absl::StrCat("environment ", game, ": "));
      return {status.code(), absl::StrCat("environment ", environment, ": ", message)};
    }
    awaits_reset[static_cast<size_t>(environment)] = model_->AwaitsReset(game);
  }
  awaits_reset_ = std::move(awaits_reset);
  return absl::OkStatus();
}

void FleetPool::Put(std::vector<v1::State> states, std::shared_ptr<Done> done) {
  const std::vector<bool> awaited_reset = awaits_reset_;
  if (absl::Status status = CheckStates(states); !status.ok() || states.empty()) {
    (*done)(std::move(status));
    return;
  }
  std::set<size_t> concerned;
  for (const v1::State& state : states) {
    concerned.insert(ShardOf(state.environment()));
  }
  ForgetLog();
  const int64_t number = Log({{}, std::move(states), 0});
  auto countdown = std::make_shared<Countdown>(
      concerned.size(), [this, number, awaited_reset, done](absl::Status status) {
        if (!status.ok()) {
          for (const std::unique_ptr<Shard>& shard : shards_) {
            shard->Forget(number - 1);
          }
          TakeBackLogged();
          awaits_reset_ = awaited_reset;
        }
        (*done)(std::move(status));
      });
  for (const size_t i : concerned) {
    shards_[i]->Run(number, [countdown](const absl::Status& status) { countdown->Count(status); });
  }
}

void FleetPool::RestoreStates(std::vector<StateToRestore> states, Done done) {
  side_crew_->Run(
      [this, states = std::move(states), done = std::make_shared<Done>(std::move(done))] {
        std::vector<v1::State> messages;
        for (const StateToRestore& state : states) {
          messages.emplace_back();
          messages.back().set_environment(state.environment);
          messages.back().set_snapshot(std::string(state.snapshot));
        }
        Put(std::move(messages), done);
      });
}

void FleetPool::CloneStates(std::vector<StateToClone> pairs, Done done) {
  // A source may be read several times, and a node is asked for it once.
  std::map<int32_t, size_t> places;
  std::vector<int32_t> sources;
  for (const StateToClone& pair : pairs) {
    if (places.emplace(pair.source_environment, sources.size()).second) {
      sources.push_back(pair.source_environment);
    }
  }
  Gather(std::move(sources), [this, pairs = std::move(pairs), places = std::move(places),
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
    side_crew_->Run([this, states = std::move(states), done] { Put(states, done); });
  });
}

void FleetPool::Render(absl::Span<const int32_t> environments, int32_t side_px,
                       std::vector<absl::Span<uint8_t>> frames, Done done) {
  const std::vector<Chosen> chosen = Choose(environments);
  size_t count = 0;
  for (const Chosen& each : chosen) {
    count += each.environments.empty() ? 0 : 1;
  }
  auto countdown = std::make_shared<Countdown>(count, std::move(done));
  for (size_t i = 0; i < shards_.size(); ++i) {
    if (chosen[i].environments.empty()) {
      continue;
    }
    std::vector<absl::Span<uint8_t>> own;
    for (const size_t place : chosen[i].places) {
      own.push_back(frames[place]);
    }
    shards_[i]->Render(chosen[i].environments, side_px, std::move(own),
                       [countdown](const absl::Status& status) { countdown->Count(status); });
  }
}

}  // namespace procgen
