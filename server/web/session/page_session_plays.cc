// The methods of plays and replays.

#include <utility>

#include "absl/strings/str_cat.h"
#include "envcore/trace/trace.h"
#include "server/web/play/episode_trace.h"
#include "server/web/session/page_session.h"

namespace procgen::web {
namespace {

// Adds the number of the play or replay to an answer.
absl::StatusOr<Answer> Of(const char* kind, int64_t number, absl::StatusOr<Answer> answer) {
  if (answer.ok()) {
    answer->result[kind] = number;
  }
  return answer;
}

Answer TraceAnswer(Json facts, std::string file) {
  Answer answer{std::move(facts), {}};
  answer.parts.push_back({"trace", "trace", std::move(file)});
  return answer;
}

absl::Status TooMany(const char* what, size_t limit) {
  return absl::ResourceExhaustedError(
      absl::StrCat("the page has ", limit, " ", what, ", which is the limit; close one"));
}

int64_t NumberIn(const Request& request, const char* kind) {
  return request.members.at(kind).get<int64_t>();
}

}  // namespace

absl::StatusOr<Play*> PageSession::FindPlay(RequestParams* params) {
  const int64_t number = params->Integer("play", 1, kIdMax);
  if (absl::Status status = params->CheckAll(); !status.ok()) {
    return status;
  }
  const auto found = plays_.find(number);
  if (found == plays_.end()) {
    return absl::NotFoundError(absl::StrCat("the page has no play ", number));
  }
  return found->second.get();
}

absl::StatusOr<PageSession::OpenReplay*> PageSession::FindReplay(RequestParams* params) {
  const int64_t number = params->Integer("replay", 1, kIdMax);
  if (absl::Status status = params->CheckAll(); !status.ok()) {
    return status;
  }
  const auto found = replays_.find(number);
  if (found == replays_.end()) {
    return absl::NotFoundError(absl::StrCat("the page has no replay ", number));
  }
  return &found->second;
}

absl::StatusOr<Answer> PageSession::AddPlay(std::unique_ptr<Play> play) {
  absl::StatusOr<Answer> view = play->View();
  if (!view.ok()) {
    return view.status();
  }
  const int64_t number = next_number_++;
  plays_[number] = std::move(play);
  return Of("play", number, std::move(view));
}

absl::StatusOr<Answer> PageSession::ContinueTrace(const Request& request) {
  RequestParams params(request.members);
  const int32_t human_size_px = ReadHumanSize(&params);
  const int32_t row = params.Integer32("row", 0, INT32_MAX);
  const absl::StatusOr<ReplaySource> source = SourceOf(request, &params);
  if (!source.ok()) {
    return source.status();
  }
  if (plays_.size() >= kPlaysMax) {
    return TooMany("plays", kPlaysMax);
  }
  const absl::StatusOr<std::unique_ptr<Replay>> replay =
      Replay::Open(client_, *source, human_size_px, is_stopping_);
  if (!replay.ok()) {
    return replay.status();
  }
  absl::StatusOr<Branch> branch = (*replay)->BranchAt(row);
  if (!branch.ok()) {
    return branch.status();
  }
  absl::StatusOr<std::unique_ptr<Play>> play =
      Play::Continue(client_, *std::move(branch), human_size_px);
  if (!play.ok()) {
    return play.status();
  }
  absl::StatusOr<Answer> view = AddPlay(*std::move(play));
  if (view.ok()) {
    view->result["header"] = (*replay)->facts()["header"];
  }
  return view;
}

absl::StatusOr<Answer> PageSession::StartPlay(const Request& request) {
  if (!request.parts.empty()) {
    return ContinueTrace(request);
  }
  RequestParams params(request.members);
  const LevelChoice choice = ReadLevelChoice(catalog_, "level_seed", &params);
  const int32_t human_size_px = ReadHumanSize(&params);
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  if (plays_.size() >= kPlaysMax) {
    return TooMany("plays", kPlaysMax);
  }
  absl::StatusOr<std::unique_ptr<Play>> play = Play::Start(client_, choice, human_size_px);
  if (!play.ok()) {
    return play.status();
  }
  return AddPlay(*std::move(play));
}

absl::StatusOr<Answer> PageSession::StepPlay(const Request& request) {
  RequestParams params(request.members);
  const int32_t action =
      params.Integer32("action", 0, static_cast<int32_t>(catalog_.actions_size()) - 1);
  constexpr int32_t kAny = -1;
  const int32_t episode_count = params.Integer32Or("episode_count", kAny, 0, INT32_MAX);
  constexpr int32_t kUnchanged = -1;
  const int32_t human_size_px = params.Has("human_size_px") ? ReadHumanSize(&params) : kUnchanged;
  const absl::StatusOr<Play*> play = FindPlay(&params);
  if (!play.ok()) {
    return play.status();
  }
  if (const int32_t finished = (*play)->recording().episode_count();
      episode_count != kAny && episode_count != finished) {
    return absl::FailedPreconditionError(absl::StrCat("episode_count is ", episode_count,
                                                      ", the play has finished ", finished,
                                                      " episodes; nothing was stepped"));
  }
  if (human_size_px != kUnchanged) {
    (*play)->set_human_size_px(human_size_px);
  }
  return Of("play", NumberIn(request, "play"), (*play)->Step(action));
}

absl::StatusOr<Answer> PageSession::RestartPlay(const Request& request) {
  RequestParams params(request.members);
  const absl::StatusOr<Play*> play = FindPlay(&params);
  if (!play.ok()) {
    return play.status();
  }
  return Of("play", NumberIn(request, "play"), (*play)->Restart());
}

absl::StatusOr<Answer> PageSession::NextLevel(const Request& request) {
  RequestParams params(request.members);
  const absl::StatusOr<Play*> play = FindPlay(&params);
  if (!play.ok()) {
    return play.status();
  }
  return Of("play", NumberIn(request, "play"), (*play)->NextLevel());
}

absl::StatusOr<Answer> PageSession::PlayTrace(const Request& request) {
  RequestParams params(request.members);
  const absl::StatusOr<Play*> play = FindPlay(&params);
  if (!play.ok()) {
    return play.status();
  }
  const Recording& recording = (*play)->recording();
  return TraceAnswer(recording.FileFacts(), TraceFileOf(recording.trace()));
}

absl::StatusOr<Answer> PageSession::ClosePlay(const Request& request) {
  RequestParams params(request.members);
  if (const absl::StatusOr<Play*> play = FindPlay(&params); !play.ok()) {
    return play.status();
  }
  plays_.erase(NumberIn(request, "play"));
  return Answer();
}

absl::StatusOr<Answer> PageSession::GetEpisode(const Request& request) {
  RequestParams params(request.members);
  const EpisodeChoice choice = ReadEpisodeChoice(&params);
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  absl::StatusOr<EpisodeTrace> episode = TraceOfEpisode(client_, choice, is_stopping_);
  if (!episode.ok()) {
    return episode.status();
  }
  return TraceAnswer(std::move(episode->facts), TraceFileOf(episode->recording.trace()));
}

absl::StatusOr<ReplaySource> PageSession::SourceOf(const Request& request, RequestParams* params) {
  if (!request.parts.empty()) {
    const int32_t environment = params->Integer32Or("environment", 0, 0, INT32_MAX);
    if (absl::Status status = params->CheckAll(); !status.ok()) {
      return status;
    }
    const Part& part = request.parts.front();
    if (request.parts.size() > 1 || part.format != "trace") {
      return absl::InvalidArgumentError(
          absl::StrCat(request.method, " takes one part, of the format trace"));
    }
    absl::StatusOr<Trace> trace = ParseTrace(part.bytes);
    if (!trace.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("the file is not a trace: ", trace.status().message()));
    }
    return ReplaySource{*std::move(trace), environment};
  }
  if (params->Has("pool")) {
    const EpisodeChoice choice = ReadEpisodeChoice(params);
    if (absl::Status status = params->CheckAll(); !status.ok()) {
      return status;
    }
    const absl::StatusOr<EpisodeTrace> episode = TraceOfEpisode(client_, choice, is_stopping_);
    if (!episode.ok()) {
      return episode.status();
    }
    return ReplaySource{episode->recording.trace(), 0};
  }
  const absl::StatusOr<Play*> play = FindPlay(params);
  if (!play.ok()) {
    return play.status();
  }
  return ReplaySource{(*play)->recording().trace(), 0};
}

absl::StatusOr<Answer> PageSession::OpenTrace(const Request& request) {
  RequestParams params(request.members);
  const int32_t human_size_px = ReadHumanSize(&params);
  absl::StatusOr<ReplaySource> source = SourceOf(request, &params);
  if (!source.ok()) {
    return source.status();
  }
  if (replays_.size() >= kReplaysMax) {
    return TooMany("replays", kReplaysMax);
  }
  absl::StatusOr<std::unique_ptr<Replay>> replay =
      Replay::Open(client_, *source, human_size_px, is_stopping_);
  if (!replay.ok()) {
    return replay.status();
  }
  const int64_t number = next_number_++;
  Answer answer{(*replay)->facts(), {}};
  replays_[number] = {*std::move(replay), request.parts.empty() ? TraceFileOf(source->trace)
                                                                : request.parts.front().bytes};
  return Of("replay", number, std::move(answer));
}

absl::StatusOr<Answer> PageSession::SeekReplay(const Request& request) {
  RequestParams params(request.members);
  const int32_t row = params.Integer32("row", 0, INT32_MAX);
  const int32_t map_size_px =
      params.Integer32Or("map_size_px", 0, Replay::kMapSizePxMin, Replay::kMapSizePxMax);
  const absl::StatusOr<OpenReplay*> found = FindReplay(&params);
  if (!found.ok()) {
    return found.status();
  }
  return Of("replay", NumberIn(request, "replay"), (*found)->replay->Seek(row, map_size_px));
}

absl::StatusOr<Answer> PageSession::ReplayTrace(const Request& request) {
  RequestParams params(request.members);
  const absl::StatusOr<OpenReplay*> found = FindReplay(&params);
  if (!found.ok()) {
    return found.status();
  }
  return TraceAnswer((*found)->replay->recording().FileFacts(), (*found)->file);
}

absl::StatusOr<Answer> PageSession::CloseReplay(const Request& request) {
  RequestParams params(request.members);
  if (const absl::StatusOr<OpenReplay*> found = FindReplay(&params); !found.ok()) {
    return found.status();
  }
  replays_.erase(NumberIn(request, "replay"));
  return Answer();
}

}  // namespace procgen::web
