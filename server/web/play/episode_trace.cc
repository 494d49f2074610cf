#include "server/web/play/episode_trace.h"

#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/web/play/single_env_pool.h"
#include "server/wire/convert_pool.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

// Actions between checks for cancellation.
constexpr size_t kActionsAtATime = 256;

absl::string_view TextOf(v1::IncompleteReason reason) {
  switch (reason) {
    case v1::INCOMPLETE_REASON_STATE_RESTORED:
      return "a state was restored during the episode";
    case v1::INCOMPLETE_REASON_TOO_OLD:
      return "the episode began too long ago, and its first steps were dropped (limit "
             "episode_history_bytes_max)";
    default:
      return "the reason is unknown";
  }
}

absl::Status CheckBeginning(const v1::Episode& episode) {
  if (episode.incomplete_reason() != v1::INCOMPLETE_REASON_UNSPECIFIED) {
    return absl::FailedPreconditionError(absl::StrCat("the beginning of this episode is missing: ",
                                                      TextOf(episode.incomplete_reason())));
  }
  if (episode.level_seed() < 0) {
    return absl::FailedPreconditionError(absl::StrCat("the episode began with level ",
                                                      episode.level_seed(),
                                                      ", which a trace cannot begin with"));
  }
  return absl::OkStatus();
}

std::vector<int32_t> ActionsOf(const v1::Episode& episode) {
  std::vector<int32_t> actions;
  for (const char action : episode.actions()) {
    actions.push_back(static_cast<int8_t>(action));
  }
  return actions;
}

absl::Status LevelsWereSelected() {
  return absl::FailedPreconditionError(
      "the levels of this episode were selected individually, which a trace cannot represent");
}

// Whether the replay equals the episode. With repeated actions, rewards are sums and are not
// compared; equal level changes suffice.
bool IsTheSame(const v1::Episode& episode, const Trace& trace) {
  for (const v1::LevelChange& change : episode.level_changes()) {
    if (trace.level_seeds[static_cast<size_t>(change.action()) + 1] != change.level_seed()) {
      return false;
    }
  }
  if (!episode.action_counts().empty()) {
    return true;
  }
  return trace.rewards.size() == static_cast<size_t>(episode.rewards_size()) + 1 &&
         std::memcmp(&trace.rewards[1], episode.rewards().data(),
                     static_cast<size_t>(episode.rewards_size()) * sizeof(float)) == 0;
}

// Errors: those of the server; FAILED_PRECONDITION the episode ends earlier than the given one;
// CANCELLED `is_stopping`.
absl::StatusOr<Recording> PlayAgain(const v1::Episode& episode, SingleEnvPool* pool,
                                    const std::atomic<bool>& is_stopping) {
  const absl::StatusOr<PoolOptions> options = PoolOptionsOf(pool->spec());
  if (!options.ok()) {
    return options.status();
  }
  const absl::StatusOr<Row> start = pool->Observe();
  if (!start.ok()) {
    return start.status();
  }
  Recording recording(options->games, options->environment);
  recording.Begin(*start);
  const std::vector<int32_t> actions = ActionsOf(episode);
  for (size_t played = 0; played < actions.size();) {
    if (is_stopping) {
      return absl::CancelledError("the page disconnected");
    }
    const auto part = absl::MakeConstSpan(actions).subspan(played, kActionsAtATime);
    // Only the last action ends the episode.
    const absl::StatusOr<bool> is_the_same = pool->StepAll(
        part, [](size_t) { return false; },
        [&](const Row& row) { recording.Add(actions[played++], row); });
    if (!is_the_same.ok()) {
      return is_the_same.status();
    }
    if (!*is_the_same) {
      return LevelsWereSelected();
    }
  }
  return recording;
}

Json FactsOf(const EpisodeChoice& choice, const v1::Episode& episode, const Recording& recording) {
  Json facts = recording.FileFacts();
  facts["pool"] = choice.pool;
  facts["environment"] = choice.environment;
  facts["ended"] = episode.outcome() != v1::EPISODE_OUTCOME_UNDER_WAY;
  facts["prev_level_complete"] = episode.level_complete();
  return facts;
}

}  // namespace

EpisodeChoice ReadEpisodeChoice(RequestParams* params) {
  EpisodeChoice choice;
  choice.pool = params->Text("pool");
  choice.environment = params->Integer32("environment", 0, INT32_MAX);
  if (!params->Has("episode")) {
    choice.is_current = params->Choice("selector", {"last", "current"}) == "current";
  } else if (const std::string text = params->Text("episode");
             text.size() != 16 || !absl::SimpleHexAtoi(text, &choice.fingerprint) ||
             choice.fingerprint == 0) {
    params->Refuse(
        absl::StrCat("episode is '", text, "', allowed: 16 hexadecimal digits, not all 0"));
  }
  return choice;
}

absl::StatusOr<EpisodeTrace> TraceOfEpisode(std::shared_ptr<procgen_client::Client> client,
                                            const EpisodeChoice& choice,
                                            const std::atomic<bool>& is_stopping) {
  const absl::StatusOr<v1::Episode> episode =
      choice.fingerprint != 0 ? client->FindEpisode(choice.pool, choice.environment,
                                                    static_cast<int64_t>(choice.fingerprint))
                              : client->GetEpisode(choice.pool, choice.environment,
                                                   choice.is_current ? v1::EPISODE_SELECTOR_CURRENT
                                                                     : v1::EPISODE_SELECTOR_LAST);
  if (!episode.ok()) {
    return episode.status();
  }
  if (absl::Status status = CheckBeginning(*episode); !status.ok()) {
    return status;
  }
  v1::PoolSpec spec;
  spec.add_games(episode->game());
  spec.set_env_count(1);
  *spec.mutable_options() = episode->options();
  const absl::StatusOr<std::unique_ptr<SingleEnvPool>> pool =
      SingleEnvPool::Make(std::move(client), "replay", spec);
  if (!pool.ok()) {
    return pool.status();
  }
  absl::StatusOr<Recording> recording = PlayAgain(*episode, pool->get(), is_stopping);
  if (!recording.ok()) {
    return recording.status();
  }
  if (!IsTheSame(*episode, recording->trace())) {
    return LevelsWereSelected();
  }
  Json facts = FactsOf(choice, *episode, *recording);
  return EpisodeTrace{std::move(facts), *std::move(recording)};
}

}  // namespace procgen::web
