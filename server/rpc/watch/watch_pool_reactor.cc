#include "server/rpc/watch/watch_pool_reactor.h"

#include <utility>

#include "procgen/v1/render.pb.h"
#include "server/rpc/grpc/method_name.h"
#include "server/rpc/grpc/parse_message.h"
#include "server/rpc/grpc/shared_bytes.h"
#include "server/wire/convert_frames.h"

namespace procgen {

WatchPoolReactor* WatchPoolReactor::Start(Sessions* sessions, const Callers* callers,
                                          Caller caller) {
  std::shared_ptr<WatchPoolReactor> reactor(
      new WatchPoolReactor(sessions, callers, std::move(caller)));
  reactor->weak_self_ = reactor;
  reactor->Begin(reactor);
  return reactor.get();
}

WatchPoolReactor::WatchPoolReactor(Sessions* sessions, const Callers* callers, Caller caller)
    : LatestStream(callers, MethodNameOf<v1::WatchPoolRequest>()),
      sessions_(sessions),
      caller_(std::move(caller)) {}

void WatchPoolReactor::OnRequest(absl::StatusOr<grpc::ByteBuffer> request) {
  const Caller caller = std::move(caller_);
  const absl::Status status = request.ok() ? Watch(caller, *request) : request.status();
  if (!status.ok()) {
    Close(status);
  }
}

absl::Status WatchPoolReactor::Watch(const Caller& caller, const grpc::ByteBuffer& request) {
  v1::WatchPoolRequest message;
  if (absl::Status status = ParseMessage(request, &message); !status.ok()) {
    return status;
  }
  const auto pool = sessions_->FindForStream(caller.owner, message.pool());
  if (!pool.ok()) {
    return pool.status();
  }
  const absl::StatusOr<WatchOrder> order = WatchOrderOf(message, **pool, sessions_->limits());
  if (!order.ok()) {
    return order.status();
  }
  absl::StatusOr<Owners::Share> share = sessions_->owners().Take(caller.owner, {.watch_count = 1});
  if (!share.ok()) {
    return share.status();
  }
  share_ = *std::move(share);
  const auto encode = [format = message.format()](Moment moment) {
    return EncodeWatched(format, std::move(moment));
  };
  absl::Status status = sessions_->views().Watch(*pool, *order, encode, weak_self_.lock());
  if (!status.ok()) {
    End(status);
  }
  return absl::OkStatus();
}

void WatchPoolReactor::Take(const absl::Cord& moment) {
  Send([moment] { return ByteBufferOf(moment); });
}

void WatchPoolReactor::End(const absl::Status& reason) {
  // A lease that ran out ends a watch as a deletion does.
  Close(absl::IsNotFound(reason) ? absl::AbortedError(reason.message()) : reason);
}

void WatchPoolReactor::LetGo() {
  sessions_->views().Leave(this);
  share_ = Owners::Share();  // a moment that is still on its way to this may hold it for a while
}

}  // namespace procgen
