#include "server/rpc/watch_pool_reactor.h"

#include <utility>

#include "procgen/v1/render.pb.h"
#include "server/rpc/method_name.h"
#include "server/rpc/shared_bytes.h"

namespace procgen {

WatchPoolReactor* WatchPoolReactor::Start(PoolViews* views, const Callers* callers,
                                          std::shared_ptr<PoolSession> pool,
                                          const WatchOrder& order, const EncodeMoment& encode,
                                          Owners::Share share) {
  std::shared_ptr<WatchPoolReactor> reactor(new WatchPoolReactor(views, callers, std::move(share)));
  reactor->Keep(reactor);
  if (absl::Status status = views->Watch(std::move(pool), order, encode, reactor); !status.ok()) {
    reactor->End(status);
  }
  return reactor.get();
}

WatchPoolReactor::WatchPoolReactor(PoolViews* views, const Callers* callers, Owners::Share share)
    : LatestStream(callers, MethodNameOf<v1::WatchPoolRequest>()),
      views_(views),
      share_(std::move(share)) {}

void WatchPoolReactor::Take(const absl::Cord& moment) {
  Send([moment] { return ByteBufferOf(moment); });
}

void WatchPoolReactor::End(const absl::Status& reason) {
  // A lease that ran out ends a watch as a deletion does.
  Close(absl::IsNotFound(reason) ? absl::AbortedError(reason.message()) : reason);
}

void WatchPoolReactor::LetGo() {
  views_->Leave(this);
  share_ = Owners::Share();  // a moment that is still on its way to this may hold it for a while
}

}  // namespace procgen
