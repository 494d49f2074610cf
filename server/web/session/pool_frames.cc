#include "server/web/session/pool_frames.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/types/span.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

// Largest size of frames as differences to previous ones, and the sizes of which they are the
// default: such frames are small and frequent.
constexpr int32_t kDeflateSizePxMax = 64;
constexpr double kFramesPerSecondDefault = 15;
constexpr double kFramesPerSecondMin = 0.1;
// Limit of a WatchPool response.
constexpr int64_t kResponseBytesMax = 16 << 20;
// Limit of one frame message; two may be queued per watch.
constexpr int64_t kRawBytesMax = 4 << 20;
constexpr int64_t kFrameOverheadBytes = 64;

absl::Status CheckEnvironments(const v1::WatchPoolRequest& request, const v1::Pool& pool) {
  for (const int32_t environment : request.environments()) {
    if (environment >= pool.spec().env_count()) {
      return absl::InvalidArgumentError(absl::StrCat("environments has ", environment, ", ",
                                                     pool.name(), " has environments 0 to ",
                                                     pool.spec().env_count() - 1));
    }
  }
  return absl::OkStatus();
}

FrameEncoding ReadEncoding(int32_t size_px, RequestParams* params) {
  if (!params->Has("format")) {
    return size_px <= kDeflateSizePxMax ? FrameEncoding::kDeflate : FrameEncoding::kPng;
  }
  const std::string name = params->Choice("format", {"deflate", "rgb", "png"});
  if (name == "deflate" && size_px > kDeflateSizePxMax) {
    params->Refuse(absl::StrCat("size_px is ", size_px,
                                ", allowed with the format deflate: at most ", kDeflateSizePxMax));
  }
  return name == "deflate" ? FrameEncoding::kDeflate
         : name == "rgb"   ? FrameEncoding::kRgb
                           : FrameEncoding::kPng;
}

}  // namespace

WatchParams ReadWatch(RequestParams* params) {
  WatchParams watch;
  v1::WatchPoolRequest& request = watch.request;
  request.set_pool(params->Text("pool"));
  for (const int32_t environment :
       params->Integers("environments", kWatchEnvironmentsMax, INT32_MAX)) {
    request.add_environments(environment);
  }
  const int32_t size_px = params->Integer32("size_px", kWatchSizePxMin, kWatchSizePxMax);
  request.set_size_px(size_px);
  request.set_frames_per_second_max(static_cast<float>(params->NumberOr(
      "frames_per_second_max", kFramesPerSecondDefault, kFramesPerSecondMin, kFramesPerSecondMax)));
  watch.encoding = ReadEncoding(size_px, params);
  request.set_format(watch.encoding == FrameEncoding::kPng ? v1::FRAME_FORMAT_PNG
                                                           : v1::FRAME_FORMAT_RGB);
  request.set_with_steps(params->BooleanOr("with_steps", false));
  // PNG files are smaller than the pixels.
  const int64_t bytes_max =
      watch.encoding == FrameEncoding::kRgb ? kRawBytesMax : kResponseBytesMax;
  const int64_t frame_bytes = int64_t{size_px} * size_px * 3 + kFrameOverheadBytes;
  if (request.environments_size() * frame_bytes + kFrameOverheadBytes > bytes_max) {
    params->Refuse(absl::StrCat("environments has ", request.environments_size(),
                                " entries, allowed: at most ",
                                (bytes_max - kFrameOverheadBytes) / frame_bytes, " with size_px ",
                                size_px, " as ", NameOf(watch.encoding)));
  }
  return watch;
}

absl::StatusOr<std::unique_ptr<PoolFrames>> PoolFrames::Start(
    std::shared_ptr<procgen_client::Client> client, const WatchParams& params, int64_t number,
    std::shared_ptr<Outbox> outbox, ThreadGroup* threads, DifferenceCache* differences) {
  const absl::StatusOr<v1::Pool> pool = client->GetPool(params.request.pool());
  if (!pool.ok()) {
    return pool.status();
  }
  if (absl::Status status = CheckEnvironments(params.request, *pool); !status.ok()) {
    return status;
  }
  auto shared = std::make_shared<Shared>();
  shared->client = std::move(client);
  shared->watch = shared->client->Watch(params.request);
  shared->encoder = std::make_shared<FrameEncoder>(number, params.encoding, differences);
  shared->number = number;
  shared->outbox = std::move(outbox);
  if (absl::Status status = threads->Start([shared] { shared->Run(); }); !status.ok()) {
    return status;
  }
  return std::unique_ptr<PoolFrames>(new PoolFrames(std::move(shared)));
}

PoolFrames::~PoolFrames() {
  shared_->is_stopping.Notify();
  shared_->watch->Stop();
  shared_->has_ended.WaitForNotification();
  shared_->outbox->DropEvent(shared_->Key());
}

std::string PoolFrames::Shared::Key() const { return absl::StrCat("frames-", number); }

void PoolFrames::Shared::Run() {
  may_begin.WaitForNotification();
  absl::StatusOr<v1::WatchPoolResponse> response = watch->Next();
  for (; response.ok(); response = watch->Next()) {
    // Frames that are not sent are not part of the encoder's state.
    outbox->SendFrames(Key(), [encoder = encoder, frames = *std::move(response)]() mutable {
      return encoder->Encode(std::move(frames));
    });
  }
  if (!is_stopping.HasBeenNotified()) {
    Json event = EndedEvent("watch_ended", response.status());
    event["watch"] = number;
    outbox->SendEvent(EncodeEvent(std::move(event)));
  }
  has_ended.Notify();
}

}  // namespace procgen::web
