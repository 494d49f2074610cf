#include "server/rpc/render_service.h"

#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/rpc/method_name.h"
#include "server/rpc/refused_stream.h"
#include "server/rpc/response_limit.h"
#include "server/rpc/unary_call.h"
#include "server/session/environment_list.h"

namespace procgen {
namespace {

using RenderCall = UnaryCall<v1::RenderEnvironmentsRequest, v1::RenderEnvironmentsResponse>;

constexpr int32_t kSidePxDefault = 512;
// All that a frame, and the response around the frames, has besides the image, in bytes.
constexpr int64_t kFrameOverheadBytes = 64;

int32_t SidePx(const v1::RenderEnvironmentsRequest& request) {
  return request.side_px() == 0 ? kSidePxDefault : request.side_px();
}

absl::Status CheckSize(const v1::RenderEnvironmentsRequest& request, const Limits& limits) {
  const absl::StatusOr<int64_t> bytes_max =
      ResponseBytesMax("response_bytes_max", request.response_bytes_max(), limits);
  if (!bytes_max.ok()) {
    return bytes_max.status();
  }
  const int64_t side = SidePx(request);
  const int64_t frame_bytes = side * side * 3 + kFrameOverheadBytes;
  const int64_t frames_max = (*bytes_max - kFrameOverheadBytes) / frame_bytes;
  if (request.environments_size() > frames_max) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "environments has ", request.environments_size(), " entries, limit response_bytes_max = ",
        *bytes_max, " has room for ", frames_max, " frames of ", side, " x ", side, " pixels"));
  }
  return absl::OkStatus();
}

absl::Status CheckRender(const v1::RenderEnvironmentsRequest& request, const PoolSession& pool,
                         const Limits& limits) {
  if (!v1::FrameFormat_IsValid(request.format())) {
    return absl::InvalidArgumentError(absl::StrCat(
        "format is number ", static_cast<int>(request.format()), ", allowed: FRAME_FORMAT_RGB"));
  }
  if (request.format() == v1::FRAME_FORMAT_PNG) {
    return absl::UnimplementedError(
        "format is FRAME_FORMAT_PNG, which is not offered yet; offered: FRAME_FORMAT_RGB");
  }
  if (const int32_t side = SidePx(request);
      side < kHumanViewSidePxMin || side > kHumanViewSidePxMax) {
    return absl::InvalidArgumentError(absl::StrCat(
        "side_px is ", side, ", allowed: ", kHumanViewSidePxMin, " to ", kHumanViewSidePxMax));
  }
  if (absl::Status status = CheckEnvironmentList(
          {.list = "environments",
           .environments = absl::MakeConstSpan(request.environments().data(),
                                               static_cast<size_t>(request.environments_size())),
           .repeats_allowed = true},
          pool.name(), pool.env_count());
      !status.ok()) {
    return status;
  }
  return CheckSize(request, limits);
}

// Draws straight into the response, in a turn at the pool.
void Render(const std::shared_ptr<PoolSession>& pool, RenderCall* call) {
  const int32_t side = SidePx(call->request());
  std::vector<absl::Span<uint8_t>> images;
  for (const int32_t environment : call->request().environments()) {
    v1::Frame* frame = call->response()->add_frames();
    frame->set_environment(environment);
    frame->set_width_px(side);
    frame->set_height_px(side);
    std::string* image = frame->mutable_image();
    image->resize(static_cast<size_t>(side) * static_cast<size_t>(side) * 3);
    images.push_back(absl::MakeSpan(reinterpret_cast<uint8_t*>(image->data()), image->size()));
  }
  call->response()->set_sequence_number(pool->next_sequence_number() - 1);
  const absl::Span<const int32_t> environments =
      absl::MakeConstSpan(call->request().environments().data(), images.size());
  pool->Render(environments, side, std::move(images), [pool, call](const absl::Status& status) {
    pool->EndTurn();
    call->Finish(status);
  });
}

}  // namespace

grpc::ServerUnaryReactor* RenderServiceImpl::RenderEnvironments(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
    grpc::ByteBuffer* response) {
  return RenderCall::Start(*callers_, *context, request, response, [this](RenderCall* call) {
    absl::StatusOr<std::shared_ptr<PoolSession>> pool =
        sessions_->Find(call->owner(), call->request().pool());
    absl::Status status = pool.status();
    if (status.ok()) {
      status = CheckRender(call->request(), **pool, sessions_->limits());
    }
    if (!status.ok()) {
      call->Finish(status);
      return;
    }
    (*pool)->TakeTurn([pool = *pool, call](const absl::Status& turn) {
      if (!turn.ok()) {
        call->Finish(turn);
        return;
      }
      Render(pool, call);
    });
  });
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* RenderServiceImpl::WatchPool(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  v1::WatchPoolRequest message;
  absl::Status status = callers_->Admit(*context).status();
  if (status.ok()) {
    status = ParseMessage(*request, &message);
  }
  if (status.ok()) {
    status = absl::UnimplementedError(
        "watching is not offered yet; call RenderEnvironments from time to time");
  }
  return new RefusedStream<grpc::ServerWriteReactor<grpc::ByteBuffer>>(
      callers_->Dismiss(MethodNameOf<v1::WatchPoolRequest>(), status));
}

}  // namespace procgen
