// What a FleetPool does with states, and what it shows to people.

#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "server/fleet/pool/countdown.h"
#include "server/fleet/pool/fleet_pool.h"

namespace procgen {

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

void FleetPool::Gather(const std::vector<int32_t>& environments,
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
    const int32_t game = (options_.first_env + environment) % model_->env_count();
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

void FleetPool::Put(std::vector<v1::State> states, const std::shared_ptr<Done>& done) {
  const std::vector<bool> awaited_reset = awaits_reset_;
  if (absl::Status status = CheckStates(states); !status.ok() || states.empty()) {
    (*done)(std::move(status));
    return;
  }
  ForgetLog();
  if (absl::Status status = CheckLog(/*may_shorten=*/false); !status.ok()) {
    awaits_reset_ = awaited_reset;
    (*done)(std::move(status));
    return;
  }
  std::set<size_t> concerned;
  for (const v1::State& state : states) {
    concerned.insert(ShardOf(state.environment()));
  }
  const int64_t number = Log({{}, std::move(states)});
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
  executor_->Run(terms_->owner, [this, states = std::move(states),
                                 done = std::make_shared<Done>(std::move(done))] {
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
  Gather(sources, [this, pairs = std::move(pairs), places = std::move(places),
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
    executor_->Run(terms_->owner, [this, states = std::move(states), done] { Put(states, done); });
  });
}

void FleetPool::CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                              CaptureDone done) {
  const size_t frame_bytes = static_cast<size_t>(size_px) * static_cast<size_t>(size_px) * 3;
  auto drawn = std::make_shared<std::vector<uint8_t>>(environments.size() * frame_bytes);
  const std::vector<Chosen> chosen = Choose(environments);
  size_t count = 0;
  for (const Chosen& each : chosen) {
    count += each.environments.empty() ? 0 : 1;
  }
  auto countdown = std::make_shared<Countdown>(
      count, [drawn, frame_bytes, done = std::move(done)](const absl::Status& status) mutable {
        if (!status.ok()) {
          done(status);
          return;
        }
        done(Draw([drawn, frame_bytes](const std::vector<absl::Span<uint8_t>>& frames) {
          for (size_t i = 0; i < frames.size(); ++i) {
            std::memcpy(frames[i].data(), drawn->data() + i * frame_bytes, frame_bytes);
          }
        }));
      });
  for (size_t i = 0; i < shards_.size(); ++i) {
    if (chosen[i].environments.empty()) {
      continue;
    }
    std::vector<absl::Span<uint8_t>> own;
    for (const size_t place : chosen[i].places) {
      own.push_back(absl::MakeSpan(*drawn).subspan(place * frame_bytes, frame_bytes));
    }
    shards_[i]->Render(chosen[i].environments, view, size_px, std::move(own),
                       [countdown](const absl::Status& status) { countdown->Count(status); });
  }
}

}  // namespace procgen
