#ifndef SERVER_WEB_SESSION_PAGE_SESSION_H_
#define SERVER_WEB_SESSION_PAGE_SESSION_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "procgen_client/client.h"
#include "server/concurrency/steady_time.h"
#include "server/concurrency/thread_group.h"
#include "server/web/json/message.h"
#include "server/web/play/play.h"
#include "server/web/play/replay.h"
#include "server/web/session/difference_cache.h"
#include "server/web/session/outbox.h"
#include "server/web/session/pool_feed.h"
#include "server/web/session/pool_frames.h"
#include "server/web/session/pool_pauses.h"
#include "server/web/session/pool_report.h"

namespace procgen::web {

// Limits per page.
inline constexpr size_t kPlaysMax = 4;
inline constexpr size_t kReplaysMax = 4;
inline constexpr size_t kWatchesMax = 4;
// Request rate of a page; further requests wait.
inline constexpr int32_t kRequestsPerSecondMax = 100;
// Attempts of hello per socket.
inline constexpr int32_t kHelloAttemptsMax = 5;

// Dependencies and settings that all page sessions share.
struct PageSessionContext {
  std::string version;
  bool requires_token = false;
  int32_t viewers_max = 0;
  // Creates a client of this server with `token`; empty: none.
  std::function<std::unique_ptr<procgen_client::Client>(const std::string& token)> connect;
  ReportEpisodes report_episodes;
  PausePool pause_pool;
  PoolFeed* feed = nullptr;
  ThreadGroup* watch_threads = nullptr;  // threads of watches
  DifferenceCache* differences = nullptr;
};

// The session of one page. Its requests block, so they are executed in order on a thread of the
// session. Plays, replays, watches and pauses end with it.
// Threads: Take and Stop from any thread, without blocking; Run on one thread, once.
class PageSession {
 public:
  // `context` must outlive this.
  PageSession(const PageSessionContext& context, std::shared_ptr<Outbox> outbox);
  ~PageSession();
  PageSession(const PageSession&) = delete;
  PageSession& operator=(const PageSession&) = delete;

  // Queues a message of the page. Each gets one Outbox::Answer, until Stop.
  void Take(WireMessage message);
  // Ends the session, for example because the page disconnected. Its pauses end at once, everything
  // else when the request in progress has ended.
  void Stop();
  // Executes queued messages until Stop.
  void Run();

 private:
  using Method = absl::StatusOr<Answer> (PageSession::*)(const Request&);
  struct OpenReplay {
    std::unique_ptr<Replay> replay;
    std::string file;  // the contents of the trace
  };

  static const std::map<std::string, Method>& Methods();
  std::optional<WireMessage> Next();
  // Waits as long as kRequestsPerSecondMax demands.
  void AwaitRate();
  void Handle(const WireMessage& message);
  absl::StatusOr<Answer> Do(const Request& request);

  absl::StatusOr<Answer> Hello(const Request& request);
  absl::StatusOr<Answer> FollowPools(const Request& request);
  absl::StatusOr<Answer> UnfollowPools(const Request& request);
  absl::StatusOr<Answer> ReadHistory(const Request& request);
  absl::StatusOr<Answer> ListReturns(const Request& request);
  absl::StatusOr<Answer> ListEpisodes(const Request& request);
  absl::StatusOr<Answer> ControlPause(const Request& request);
  absl::StatusOr<Answer> GetEpisode(const Request& request);
  absl::StatusOr<Answer> StartWatch(const Request& request);
  absl::StatusOr<Answer> StopWatch(const Request& request);
  absl::StatusOr<Answer> StartPlay(const Request& request);
  // Starts a play at a row of a trace.
  absl::StatusOr<Answer> ContinueTrace(const Request& request);
  absl::StatusOr<Answer> StepPlay(const Request& request);
  absl::StatusOr<Answer> RestartPlay(const Request& request);
  absl::StatusOr<Answer> NextLevel(const Request& request);
  absl::StatusOr<Answer> PlayTrace(const Request& request);
  absl::StatusOr<Answer> ClosePlay(const Request& request);
  absl::StatusOr<Answer> OpenTrace(const Request& request);
  absl::StatusOr<Answer> SeekReplay(const Request& request);
  absl::StatusOr<Answer> ReplayTrace(const Request& request);
  absl::StatusOr<Answer> CloseReplay(const Request& request);
  absl::StatusOr<Answer> ShowGallery(const Request& request);

  // Adds a play and returns its view.
  absl::StatusOr<Answer> AddPlay(std::unique_ptr<Play> play);
  // Reads the number of a play of this session. Errors: INVALID_ARGUMENT, NOT_FOUND.
  absl::StatusOr<Play*> FindPlay(RequestParams* params);
  absl::StatusOr<OpenReplay*> FindReplay(RequestParams* params);
  // The source of replay.open, from its members and parts.
  absl::StatusOr<ReplaySource> SourceOf(const Request& request, RequestParams* params);

  const PageSessionContext& context_;
  const std::shared_ptr<Outbox> outbox_;
  std::atomic<bool> is_stopping_ = false;

  absl::Mutex mutex_;
  SteadyCondVar stopped_;
  std::deque<WireMessage> messages_ ABSL_GUARDED_BY(mutex_);

  // Used only by the thread of Run.
  std::shared_ptr<procgen_client::Client> client_;  // null before hello is accepted
  std::string token_;
  procgen::v1::Catalog catalog_;
  int32_t hello_attempts_ = 0;
  absl::Time rate_time_ = absl::InfinitePast();  // earliest time of the next request; steady
  std::function<void()> after_answer_;           // runs after the answer is queued; may be null
  int64_t next_number_ = 1;                      // of a play, replay or watch
  std::map<int64_t, std::unique_ptr<Play>> plays_;
  std::map<int64_t, OpenReplay> replays_;
  std::map<int64_t, std::unique_ptr<PoolFrames>> watches_;

  PoolPauses pauses_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_PAGE_SESSION_H_
