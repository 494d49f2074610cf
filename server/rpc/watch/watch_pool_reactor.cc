#include "server/rpc/watch/watch_pool_reactor.h"

#include <utility>
#include <vector>

#include "procgen/v1/render.pb.h"
#include "server/rpc/grpc/parse_message.h"
#include "server/wire/convert_frames.h"

namespace procgen {

WatchPoolReactor* WatchPoolReactor::Start(PoolSupervisor* supervisor, FramePublishers* publishers,
                                          const CallAccounting* accounting, Caller caller,
                                          const grpc::ByteBuffer& request) {
  const std::shared_ptr<WatchPoolReactor> reactor(
      new WatchPoolReactor(supervisor, publishers, accounting, std::move(caller.reservation)));
  reactor->self_ = reactor;
  if (absl::Status status = Watch(reactor, caller.owner, request); !status.ok()) {
    reactor->End(status);
  }
  return reactor.get();
}

WatchPoolReactor::WatchPoolReactor(PoolSupervisor* supervisor, FramePublishers* publishers,
                                   const CallAccounting* accounting,
                                   Quotas::Reservation reservation)
    : supervisor_(supervisor),
      publishers_(publishers),
      accounting_(accounting),
      reservation_(std::move(reservation)) {}

absl::Status WatchPoolReactor::Watch(const std::shared_ptr<WatchPoolReactor>& self,
                                     const std::string& owner, const grpc::ByteBuffer& request) {
  PoolSupervisor* const supervisor = self->supervisor_;
  v1::WatchPoolRequest message;
  if (absl::Status status = ParseMessage(request, &message); !status.ok()) {
    return status;
  }
  if (supervisor->draining()) {
    return PoolSupervisor::Draining();
  }
  const auto pool = supervisor->Find(owner, message.pool());
  if (!pool.ok()) {
    return pool.status();
  }
  const absl::StatusOr<WatchSpec> spec = WatchSpecOf(message, **pool, supervisor->limits());
  if (!spec.ok()) {
    return spec.status();
  }
  if (spec->format == kDeltaFormat) {
    absl::StatusOr<Quotas::Reservation> memory =
        supervisor->quotas().Reserve(owner, {.bytes = DeltaFrameEncoder::BytesOf(*spec)});
    if (!memory.ok()) {
      return memory.status();
    }
    self->delta_memory_ = *std::move(memory);
    self->delta_encoder_.emplace(*spec);
  }
  const auto encode = [format = spec->format](FrameSet frame_set) {
    return EncodeWatched(format, std::move(frame_set));
  };
  return self->publishers_->Subscribe(*pool, *spec, encode, self);
}

bool WatchPoolReactor::IsReady() {
  absl::MutexLock lock(&mutex_);
  return !writes_ && !waiting_.has_value();
}

void WatchPoolReactor::Take(const absl::Cord& frame_set) {
  {
    absl::MutexLock lock(&mutex_);
    waiting_ = frame_set;
  }
  Continue();
}

void WatchPoolReactor::End(const absl::Status& reason) {
  {
    absl::MutexLock lock(&mutex_);
    if (end_.has_value()) {
      return;
    }
    end_ = reason;
  }
  Continue();
}

void WatchPoolReactor::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    writes_ = false;
    if (!ok && !end_.has_value()) {
      end_ = absl::OkStatus();  // the client has disconnected
    }
  }
  Continue();
}

void WatchPoolReactor::OnCancel() { End(absl::OkStatus()); }

void WatchPoolReactor::OnDone() {
  publishers_->Unsubscribe(this);
  // Released here, because a frame set in progress may keep this object alive for a while.
  reservation_ = Quotas::Reservation();
  delta_memory_ = Quotas::Reservation();
  const std::shared_ptr<WatchPoolReactor> last = std::move(self_);
}

void WatchPoolReactor::Continue() {
  std::optional<absl::Cord> frame_set;
  std::optional<absl::Status> end;
  {
    absl::MutexLock lock(&mutex_);
    if (writes_ || ended_ || !(end_.has_value() || waiting_.has_value())) {
      return;
    }
    end = end_;
    ended_ = end.has_value();
    writes_ = !ended_;
    frame_set = std::exchange(waiting_, std::nullopt);
  }
  if (end.has_value()) {
    Finish(accounting_->EndCall("PoolService/WatchPool", *end));
    return;
  }
  written_ = ResponseOf(*frame_set);
  StartWrite(&written_);
}

grpc::ByteBuffer WatchPoolReactor::ResponseOf(const absl::Cord& frame_set) {
  if (delta_encoder_.has_value()) {
    const grpc::Slice slice(delta_encoder_->Encode(frame_set));
    return {&slice, 1};
  }
  std::vector<grpc::Slice> pieces;
  for (const absl::string_view piece : frame_set.Chunks()) {
    // Shares the bytes, which the slice's copy of the cord keeps.
    pieces.emplace_back(
        const_cast<char*>(piece.data()), piece.size(),
        [](void* cord) { delete static_cast<absl::Cord*>(cord); }, new absl::Cord(frame_set));
  }
  return {pieces.data(), pieces.size()};
}

}  // namespace procgen
