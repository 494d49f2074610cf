#include "server/rpc/services/render_service.h"

#include <memory>
#include <utility>
#include <vector>

#include "server/rpc/call/refused_stream.h"
#include "server/rpc/call/unary_call.h"
#include "server/rpc/grpc/method_name.h"
#include "server/rpc/watch/watch_pool_reactor.h"
#include "server/wire/convert_frames.h"

namespace procgen {
namespace {

using RenderCall = UnaryCall<v1::RenderEnvironmentsRequest, v1::RenderEnvironmentsResponse>;

// Draws directly into the response.
void Draw(PoolBackend::Draw draw, int32_t size_px, RenderCall* call) {
  std::vector<absl::Span<uint8_t>> images;
  for (const int32_t environment : call->request().environments()) {
    v1::Frame* frame = call->response()->add_frames();
    frame->set_environment(environment);
    frame->set_size_px(size_px);
    std::string* image = frame->mutable_image();
    image->resize(static_cast<size_t>(size_px) * static_cast<size_t>(size_px) * 3);
    images.push_back(absl::MakeSpan(reinterpret_cast<uint8_t*>(image->data()), image->size()));
  }
  draw(images);
  WriteFrames(call->request().format(), call->response()->mutable_frames());
  call->Finish(absl::OkStatus());
}

// Captures scenes in a turn of the pool, and draws them after the turn.
void Render(const std::shared_ptr<PoolSession>& pool, BackgroundExecutor* executor,
            RenderCall* call) {
  const v1::RenderEnvironmentsRequest& request = call->request();
  const RenderSpec spec = RenderSpecOf(request);
  call->response()->set_sequence_number(pool->next_sequence_number() - 1);
  pool->CaptureScenes(
      {request.environments().begin(), request.environments().end()}, spec.view, spec.size_px,
      [pool, size_px = spec.size_px, executor, call](absl::StatusOr<PoolBackend::Draw> draw) {
        pool->EndTurn();
        if (!draw.ok()) {
          call->Finish(draw.status());
          return;
        }
        executor->Run(call->owner(), [draw = *std::move(draw), size_px, call]() mutable {
          Draw(std::move(draw), size_px, call);
        });
      });
}

}  // namespace

RenderServiceImpl::RenderServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting)
    : supervisor_(supervisor), accounting_(accounting) {
  AddByteMethod<v1::RenderEnvironmentsRequest>(
      [this](auto* context) { return RenderEnvironments(context); });
  AddByteMethod<v1::WatchPoolRequest>([this](auto* context) { return WatchPool(context); });
}

ByteStream* RenderServiceImpl::RenderEnvironments(grpc::CallbackServerContext* context) {
  return RenderCall::Start(*accounting_, *context, [this](RenderCall* call) {
    absl::StatusOr<std::shared_ptr<PoolSession>> pool =
        supervisor_->Find(call->owner(), call->request().pool());
    absl::Status status = pool.status();
    if (status.ok()) {
      status = CheckRender(call->request(), **pool, supervisor_->limits());
    }
    if (!status.ok()) {
      call->Finish(status);
      return;
    }
    (*pool)->TakeTurn([this, pool = *pool, call](const absl::Status& turn) {
      if (!turn.ok()) {
        call->Finish(turn);
        return;
      }
      Render(pool, &supervisor_->executor(), call);
    });
  });
}

ByteStream* RenderServiceImpl::WatchPool(grpc::CallbackServerContext* context) {
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  if (!caller.ok()) {
    return new RefusedStream(
        accounting_->EndCall(MethodNameOf<v1::WatchPoolRequest>(), caller.status()));
  }
  return WatchPoolReactor::Start(supervisor_, accounting_, *std::move(caller));
}

}  // namespace procgen
