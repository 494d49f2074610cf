#include "server/web/session/page_session.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "server/logging/event_log.h"
#include "server/web/play/gallery.h"
#include "server/web/session/convert_json.h"

namespace procgen::web {
namespace {

// Longest burst credit of kRequestsPerSecondMax.
constexpr absl::Duration kRateSaved = absl::Seconds(2);

// Whether gRPC accepts `token` in a header value. gRPC aborts the process on invalid ones.
bool IsPrintable(const std::string& text) {
  return std::all_of(text.begin(), text.end(),
                     [](unsigned char letter) { return absl::ascii_isprint(letter); });
}

}  // namespace

PageSession::PageSession(const PageSessionContext& context, std::shared_ptr<Outbox> outbox)
    : context_(context), outbox_(std::move(outbox)), pauses_(context.pause_pool) {}

PageSession::~PageSession() = default;

void PageSession::Take(WireMessage message) {
  absl::MutexLock lock(&mutex_);
  messages_.push_back(std::move(message));
}

void PageSession::Stop() {
  {
    absl::MutexLock lock(&mutex_);  // a waiter in Next cannot miss the change
    is_stopping_ = true;
    stopped_.NotifyAll();
  }
  pauses_.End();
}

std::optional<WireMessage> PageSession::Next() {
  absl::MutexLock lock(&mutex_);
  const auto is_due = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return is_stopping_ || !messages_.empty();
  };
  mutex_.Await(absl::Condition(&is_due));
  if (is_stopping_) {
    return std::nullopt;
  }
  WireMessage message = std::move(messages_.front());
  messages_.pop_front();
  return message;
}

void PageSession::AwaitRate() {
  const absl::Time now = SteadyNow();
  rate_time_ = std::max(rate_time_, now - kRateSaved) + absl::Seconds(1) / kRequestsPerSecondMax;
  if (rate_time_ > now) {
    absl::MutexLock lock(&mutex_);
    stopped_.AwaitUntil(&mutex_, rate_time_, [this] { return is_stopping_.load(); });
  }
}

void PageSession::Run() {
  while (const std::optional<WireMessage> message = Next()) {
    AwaitRate();
    Handle(*message);
  }
  context_.feed->Unfollow(this);
  watches_.clear();
  plays_.clear();
  replays_.clear();
}

void PageSession::Handle(const WireMessage& message) {
  const absl::StatusOr<Request> request = ParseRequest(message.bytes, message.is_binary);
  if (!request.ok()) {
    outbox_->Close(kCloseBadMessage, std::string(request.status().message()));
    return;
  }
  try {
    outbox_->Answer(EncodeAnswer(request->id, Do(*request)));
  } catch (const std::exception& error) {
    // The JSON library reports misuse by exceptions. All input is validated before; this keeps a
    // missed case from ending the server.
    LogEvent(LogLevel::kError, "web_request_failed",
             {{"method", request->method}, {"message", error.what()}});
    outbox_->Answer(EncodeAnswer(request->id, absl::InternalError("internal error of the server")));
  }
  if (after_answer_ != nullptr) {
    std::exchange(after_answer_, nullptr)();
  }
}

absl::StatusOr<Answer> PageSession::Do(const Request& request) {
  const auto method = Methods().find(request.method);
  if (method == Methods().end()) {
    return absl::UnimplementedError(absl::StrCat("there is no method '", request.method, "'"));
  }
  if (client_ == nullptr && request.method != "hello") {
    return absl::FailedPreconditionError(
        absl::StrCat("the method is ", request.method, ", and hello must come first"));
  }
  if (!request.parts.empty() && request.method != "replay.open" && request.method != "play.start") {
    return absl::InvalidArgumentError(absl::StrCat(request.method, " takes no parts"));
  }
  return (this->*method->second)(request);
}

const std::map<std::string, PageSession::Method>& PageSession::Methods() {
  static const auto& methods = *new std::map<std::string, Method>({
      {"hello", &PageSession::Hello},
      {"pools.follow", &PageSession::FollowPools},
      {"pools.unfollow", &PageSession::UnfollowPools},
      {"pool.history", &PageSession::ReadHistory},
      {"pools.returns", &PageSession::ListReturns},
      {"pool.episodes", &PageSession::ListEpisodes},
      {"pool.episode", &PageSession::GetEpisode},
      {"pool.pause", &PageSession::ControlPause},
      {"pool.step", &PageSession::ControlPause},
      {"pool.resume", &PageSession::ControlPause},
      {"watch.start", &PageSession::StartWatch},
      {"watch.stop", &PageSession::StopWatch},
      {"play.start", &PageSession::StartPlay},
      {"play.step", &PageSession::StepPlay},
      {"play.restart", &PageSession::RestartPlay},
      {"play.next_level", &PageSession::NextLevel},
      {"play.trace", &PageSession::PlayTrace},
      {"play.close", &PageSession::ClosePlay},
      {"replay.open", &PageSession::OpenTrace},
      {"replay.seek", &PageSession::SeekReplay},
      {"replay.trace", &PageSession::ReplayTrace},
      {"replay.close", &PageSession::CloseReplay},
      {"gallery.page", &PageSession::ShowGallery},
  });
  return methods;
}

absl::StatusOr<Answer> PageSession::Hello(const Request& request) {
  RequestParams params(request.members);
  const std::string token = params.Has("token") ? params.Text("token") : "";
  if (!IsPrintable(token)) {
    params.Refuse("token has characters that no token has");
  }
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  if (client_ != nullptr) {
    return absl::FailedPreconditionError("this socket has said hello; open another");
  }
  std::shared_ptr<procgen_client::Client> client = context_.connect(token);
  absl::StatusOr<procgen::v1::Catalog> catalog = client->GetCatalog();
  const absl::StatusOr<procgen::v1::ListNodesResponse> nodes =
      catalog.ok() ? client->ListNodes() : catalog.status();
  if (!nodes.ok()) {
    if (++hello_attempts_ >= kHelloAttemptsMax) {
      after_answer_ = [this] { outbox_->Close(kClosePolicy, "too many tokens that are none"); };
    }
    return nodes.status();
  }
  client_ = std::move(client);
  token_ = token;
  catalog_ = *std::move(catalog);
  outbox_->AcceptHello();
  return Answer{{{"version", context_.version},
                 {"requires_token", context_.requires_token},
                 {"cluster", nodes->cluster()},
                 {"node", nodes->local_node()},
                 {"art", catalog_.art()},
                 {"catalog", CatalogJson(catalog_)},
                 {"limits",
                  {{"viewers", context_.viewers_max},
                   {"plays", kPlaysMax},
                   {"replays", kReplaysMax},
                   {"watches", kWatchesMax},
                   {"watch_environments", kWatchEnvironmentsMax},
                   {"frames_per_second", kFramesPerSecondMax},
                   {"gallery_count", kGalleryCountMax},
                   {"message_bytes", kMessageBytesMax},
                   {"play_steps", Play::kStepsMax},
                   {"replay_rows", Replay::kRowsMax},
                   {"requests_per_second", kRequestsPerSecondMax}}}},
                {}};
}

absl::StatusOr<Answer> PageSession::FollowPools(const Request& request) {
  if (absl::Status status = RequestParams(request.members).CheckAll(); !status.ok()) {
    return status;
  }
  const auto tell = [outbox = outbox_](const absl::StatusOr<Json>& event) {
    if (event.ok()) {
      outbox->SendLatestEvent("pools", EncodeEvent(*event));
    } else {
      outbox->SendEvent(EncodeEvent(EndedEvent("pools_closed", event.status())));
    }
  };
  after_answer_ = [this, tell] { context_.feed->Follow(this, token_, client_, tell); };
  return Answer();
}

absl::StatusOr<Answer> PageSession::UnfollowPools(const Request& request) {
  if (absl::Status status = RequestParams(request.members).CheckAll(); !status.ok()) {
    return status;
  }
  context_.feed->Unfollow(this);
  outbox_->DropEvent("pools");
  return Answer();
}

absl::StatusOr<Answer> PageSession::StartWatch(const Request& request) {
  RequestParams params(request.members);
  const WatchParams watch = ReadWatch(&params);
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  std::erase_if(watches_, [](const auto& entry) { return entry.second->has_ended(); });
  if (watches_.size() >= kWatchesMax) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the page has ", kWatchesMax, " watches, which is the limit; stop one"));
  }
  const int64_t number = next_number_++;
  absl::StatusOr<std::unique_ptr<PoolFrames>> frames = PoolFrames::Start(
      client_, watch, number, outbox_, context_.watch_threads, context_.differences);
  if (!frames.ok()) {
    return frames.status();
  }
  after_answer_ = [frames = frames->get()] { frames->Begin(); };
  watches_[number] = *std::move(frames);
  return Answer{{{"watch", number}}, {}};
}

absl::StatusOr<Answer> PageSession::StopWatch(const Request& request) {
  RequestParams params(request.members);
  const int64_t number = params.Integer("watch", 1, kIdMax);
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  if (watches_.erase(number) == 0 && number >= next_number_) {
    return absl::NotFoundError(absl::StrCat("the page has no watch ", number));
  }
  return Answer();  // also if the watch has ended already
}

absl::StatusOr<Answer> PageSession::ShowGallery(const Request& request) {
  RequestParams params(request.members);
  const LevelChoice choice = ReadLevelChoice(catalog_, "first_level_seed", &params);
  const int32_t count_max =
      choice.has_one_level ? 1 : std::min(kGalleryCountMax, kLevelSeedMax - choice.level_seed + 1);
  const int32_t count = params.Integer32("count", 1, count_max);
  const int32_t size_px = params.Integer32("size_px", kGallerySizePxMin, kGallerySizePxMax);
  const auto view = params.BooleanOr("whole_level", false) ? procgen::v1::FRAME_VIEW_LEVEL
                                                           : procgen::v1::FRAME_VIEW_HUMAN;
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  return GalleryPage(client_, choice, count, size_px, view);
}

}  // namespace procgen::web
