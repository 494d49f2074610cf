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
#include "server/web/session/outbox.h"
#include "server/web/session/pool_feed.h"
#include "server/web/session/pool_frames.h"

namespace procgen::web {

// What each page may have of these at a time.
inline constexpr size_t kPlaysMax = 4;
inline constexpr size_t kReplaysMax = 4;
inline constexpr size_t kWatchesMax = 4;
// Requests of a page that are carried out in a second; those beyond wait.
inline constexpr int32_t kRequestsPerSecondMax = 100;
// Tokens that may be tried on one socket.
inline constexpr int32_t kHelloAttemptsMax = 5;

// What is the same for all page sessions.
struct PageSessionContext {
  std::string version;
  bool requires_token = false;
  int32_t viewers_max = 0;
  // A client of this server that shows `token`; empty: none.
  std::function<std::unique_ptr<procgen_client::Client>(const std::string& token)> connect;
  PoolFeed* feed = nullptr;
  ThreadGroup* watch_threads = nullptr;  // those of what pages watch
};

// The session with one page: its requests are carried out one after the other, on a thread of
// the session's own, for they block. Its plays, replays and watches end with it.
// Threads: Take and Stop from any thread, and none of them blocks; Run on one, once.
class PageSession {
 public:
  // `context` must outlive this.
  PageSession(const PageSessionContext& context, std::shared_ptr<Outbox> outbox);
  ~PageSession();
  PageSession(const PageSession&) = delete;
  PageSession& operator=(const PageSession&) = delete;

  // A message of the page. Each is answered by one Outbox::Answer, until there is a Stop.
  void Take(WireMessage message);
  // The page has gone, or must.
  void Stop();
  // Carries out what is taken until there is a Stop.
  void Run();

 private:
  using Method = absl::StatusOr<Answer> (PageSession::*)(const Request&);
  struct OpenReplay {
    std::unique_ptr<Replay> replay;
    std::string file;  // the contents of the trace
  };

  static const std::map<std::string, Method>& Methods();
  std::optional<WireMessage> Next();
  // Waits for the session's turn by kRequestsPerSecondMax.
  void AwaitRate();
  void Handle(const WireMessage& message);
  absl::StatusOr<Answer> Do(const Request& request);

  absl::StatusOr<Answer> Hello(const Request& request);
  absl::StatusOr<Answer> FollowPools(const Request& request);
  absl::StatusOr<Answer> UnfollowPools(const Request& request);
  absl::StatusOr<Answer> ReadHistory(const Request& request);
  absl::StatusOr<Answer> GetEpisode(const Request& request);
  absl::StatusOr<Answer> StartWatch(const Request& request);
  absl::StatusOr<Answer> StopWatch(const Request& request);
  absl::StatusOr<Answer> StartPlay(const Request& request);
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

  // Takes the number of a play of this session. Errors: INVALID_ARGUMENT, NOT_FOUND.
  absl::StatusOr<Play*> FindPlay(RequestParams* params);
  absl::StatusOr<OpenReplay*> FindReplay(RequestParams* params);
  // What replay.open is to replay, by its members and parts.
  absl::StatusOr<ReplaySource> SourceOf(const Request& request, RequestParams* params);

  const PageSessionContext& context_;
  const std::shared_ptr<Outbox> outbox_;
  std::atomic<bool> is_stopping_ = false;

  absl::Mutex mutex_;
  SteadyCondVar stopped_;
  std::deque<WireMessage> messages_ ABSL_GUARDED_BY(mutex_);

  // Of the thread.
  std::shared_ptr<procgen_client::Client> client_;  // null: the page has not said who it is
  std::string token_;
  procgen::v1::Catalog catalog_;
  int32_t hello_attempts_ = 0;
  absl::Time rate_time_ = absl::InfinitePast();  // when the next request's turn is; steady
  std::function<void()> after_answer_;  // begins what comes after an answer; null: nothing does
  int64_t next_number_ = 1;             // of a play, replay or watch
  std::map<int64_t, std::unique_ptr<Play>> plays_;
  std::map<int64_t, OpenReplay> replays_;
  std::map<int64_t, std::unique_ptr<PoolFrames>> watches_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_PAGE_SESSION_H_
