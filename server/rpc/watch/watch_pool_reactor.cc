#include "server/rpc/watch/watch_pool_reactor.h"

#include <utility>

#include "procgen/v1/render.pb.h"
#include "server/rpc/grpc/method_name.h"
#include "server/rpc/grpc/parse_message.h"
#include "server/rpc/grpc/shared_bytes.h"
#include "server/wire/convert_frames.h"

namespace procgen {

WatchPoolReactor* WatchPoolReactor::Start(PoolSupervisor* supervisor,
                                          const CallAccounting* accounting, Caller caller) {
  std::shared_ptr<WatchPoolReactor> reactor(
      new WatchPoolReactor(supervisor, accounting, std::move(caller)));
  reactor->weak_self_ = reactor;
  reactor->Begin(reactor);
  return reactor.get();
}

WatchPoolReactor::WatchPoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                   Caller caller)
    : LatestStream(accounting, MethodNameOf<v1::WatchPoolRequest>()),
      supervisor_(supervisor),
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
  const auto pool = supervisor_->FindForStream(caller.owner, message.pool());
  if (!pool.ok()) {
    return pool.status();
  }
  const absl::StatusOr<WatchSpec> spec = WatchSpecOf(message, **pool, supervisor_->limits());
  if (!spec.ok()) {
    return spec.status();
  }
  absl::StatusOr<Quotas::Reservation> reservation =
      supervisor_->quotas().Reserve(caller.owner, {.watch_count = 1});
  if (!reservation.ok()) {
    return reservation.status();
  }
  reservation_ = *std::move(reservation);
  const auto encode = [format = message.format()](FrameSet frame_set) {
    return EncodeWatched(format, std::move(frame_set));
  };
  absl::Status status =
      supervisor_->frame_publishers().Subscribe(*pool, *spec, encode, weak_self_.lock());
  if (!status.ok()) {
    End(status);
  }
  return absl::OkStatus();
}

void WatchPoolReactor::Take(const absl::Cord& frame_set) {
  Send([frame_set] { return ByteBufferOf(frame_set); });
}

void WatchPoolReactor::End(const absl::Status& reason) {
  // An expired lease ends a watch with the same code as a deletion.
  Close(absl::IsNotFound(reason) ? absl::AbortedError(reason.message()) : reason);
}

void WatchPoolReactor::ReleaseSource() {
  supervisor_->frame_publishers().Unsubscribe(this);
  // Released here, because a frame set in progress may keep this object alive for a while.
  reservation_ = Quotas::Reservation();
}

}  // namespace procgen
