#include "server/pool/pool_session.h"

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/concurrency/deadline_timer.h"

namespace procgen {
namespace {

// Multiple of the last capture's duration during which no capture runs, up to a maximum.
constexpr int kPausePerCapture = 99;
constexpr absl::Duration kPauseMax = absl::Seconds(1);
// Up to so many environments are captured faster here than on the background executor.
constexpr size_t kScenesHereMax = 64;

absl::Status NoEpisodes() {
  return absl::UnimplementedError(
      "this server remembers no episodes, limit episode_history_bytes_max is 0");
}

}  // namespace

PoolSession::PoolSession(std::string owner, std::string name, std::unique_ptr<Pool> pool,
                         SessionOptions options, EndStream end_stream, const PoolContext& context)
    : owner_(std::move(owner)),
      name_(std::move(name)),
      pool_(std::move(pool)),
      session_options_(std::move(options)),
      create_time_(absl::Now()),
      background_(context.executor),
      end_stream_(std::move(end_stream)),
      turns_(name_),
      observers_(pool_->options(), context),
      executor_({.owner = owner_,
                 .pool_name = name_,
                 .pool = pool_.get(),
                 .executor = context.executor,
                 .turns = &turns_,
                 .observers = &observers_,
                 .metrics = context.metrics}) {}

std::vector<GameReturn> PoolSession::ReadGameReturns() const {
  const std::vector<std::string>& games = options().games;
  std::vector<GameReturn> returns;
  std::map<std::string, size_t> places;
  for (const std::string& game : games) {
    places[game] = 0;
  }
  if (places.size() < 2) {
    return returns;
  }
  for (auto& [game, place] : places) {
    place = returns.size();
    returns.push_back({game, std::nullopt});
  }
  const std::vector<std::optional<float>> means =
      recent_episodes().ReadMeanReturns(returns.size(), [&](int32_t environment) {
        const auto number =
            static_cast<size_t>(options().first_env) + static_cast<size_t>(environment);
        return places[games[number % games.size()]];
      });
  for (size_t i = 0; i < returns.size(); ++i) {
    returns[i].mean_return = means[i];
  }
  return returns;
}

void PoolSession::Execute(Request* request, std::shared_ptr<ResponseSink> sink) {
  pause_.Pass([this, request, sink = std::move(sink)]() mutable {
    executor_.Execute(request, std::move(sink));
  });
}

void PoolSession::End(const absl::Status& reason) {
  EndStream end_stream;
  {
    absl::MutexLock lock(&mutex_);
    std::swap(end_stream, end_stream_);
  }
  OnStreamEnds();
  if (end_stream != nullptr) {
    end_stream(reason);
  }
}

void PoolSession::Close(const absl::Status& reason) {
  std::deque<TurnQueue::Begin> waiting = turns_.Close(reason);
  OnStreamEnds();
  EndObservers(reason);
  for (TurnQueue::Begin& begin : waiting) {
    begin(reason);
  }
}

void PoolSession::SaveStates(absl::Span<const int32_t> environments, SavedStates done) {
  background_->Run(owner_, [this, environments, done = std::move(done)]() mutable {
    done(pool_->SaveStates(environments));
  });
}

void PoolSession::RestoreStates(std::vector<StateToRestore> states, Done done) {
  observers_.AddChange();
  observers_.OnInvalidated();
  background_->Run(owner_, [this, states = std::move(states), done = std::move(done)]() mutable {
    const absl::Status status = pool_->RestoreStates(states);
    if (status.ok()) {
      observers_.OnRestore(states);
    }
    done(status);
  });
}

void PoolSession::CloneStates(std::vector<StateToClone> pairs, Done done) {
  observers_.AddChange();
  observers_.OnInvalidated();
  background_->Run(owner_, [this, pairs = std::move(pairs), done = std::move(done)]() mutable {
    const absl::Status status = pool_->CloneStates(pairs);
    if (status.ok()) {
      observers_.OnClone(pairs);
    }
    done(status);
  });
}

absl::StatusOr<EpisodeRecording> PoolSession::FindEpisode(int32_t environment,
                                                          uint64_t fingerprint) const {
  const EpisodeLog* const episodes = observers_.episodes();
  if (episodes == nullptr) {
    return NoEpisodes();
  }
  if (absl::StatusOr<EpisodeRecording> last = episodes->Read(environment, /*under_way=*/false);
      last.ok() && last->summary.fingerprint == fingerprint) {
    return last;
  }
  std::optional<EpisodeRecording> found = recent_episodes().Find(environment, fingerprint);
  if (!found.has_value()) {
    return absl::NotFoundError(
        absl::StrCat("environment ", environment, " of ", name(), " has no recording of episode ",
                     absl::Hex(fingerprint, absl::kZeroPad16), ": a pool keeps those of its last ",
                     RecentEpisodes::kListedMax, " episodes, or fewer if they are long"));
  }
  return *std::move(found);
}

void PoolSession::GetEpisode(int32_t environment, bool under_way, EpisodeDone done) {
  EpisodeLog* const episodes = observers_.episodes();
  if (episodes == nullptr) {
    done(NoEpisodes());
    return;
  }
  if (!under_way || episodes->KnowsLevel(environment)) {
    done(episodes->Read(environment, under_way));
    return;
  }
  // The environment has no steps yet, so its current values contain the episode's level seed.
  auto level_seed = std::make_unique<int32_t>(0);
  Batch batch;
  batch.level_seeds = absl::MakeSpan(level_seed.get(), 1);
  pool_->StepAsync({.first = environment, .count = 1, .steps = false}, batch,
                   [episodes, environment, level_seed = std::move(level_seed),
                    done = std::move(done)](const absl::Status& status) mutable {
                     if (!status.ok()) {
                       done(status);
                       return;
                     }
                     episodes->SetLevel(environment, *level_seed);
                     done(episodes->Read(environment, /*under_way=*/true));
                   });
}

void PoolSession::CaptureScenes(std::vector<int32_t> environments, View view, int32_t size_px,
                                Captured done) {
  if (environments.size() <= kScenesHereMax) {
    done(scene_capture_.Capture(pool_.get(), environments, view, size_px));
    return;
  }
  background_->Run(owner_, [this, environments = std::move(environments), view, size_px,
                            done = std::move(done)]() mutable {
    done(scene_capture_.Capture(pool_.get(), environments, view, size_px));
  });
}

void PoolSession::NoteCapture(absl::Time begin_time) {
  const absl::Time now = SteadyNow();
  next_capture_ns_ =
      absl::ToUnixNanos(now + std::min((now - begin_time) * kPausePerCapture, kPauseMax));
}

}  // namespace procgen
