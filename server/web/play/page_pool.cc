#include "server/web/play/page_pool.h"

#include <utility>

#include "absl/random/random.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

constexpr absl::string_view kPrefix = "web-";

}  // namespace

std::string KindOfPool(absl::string_view name) {
  if (absl::ConsumePrefix(&name, "pools/") && absl::ConsumePrefix(&name, kPrefix)) {
    for (const absl::string_view kind : {"play", "replay", "gallery"}) {
      absl::string_view rest = name;
      if (absl::ConsumePrefix(&rest, kind) && absl::ConsumePrefix(&rest, "-")) {
        return std::string(kind);
      }
    }
  }
  return "pool";
}

PagePool::PagePool(std::shared_ptr<procgen_client::Client> client)
    : client_(std::move(client)),
      stream_(client_->OpenRunPool(std::make_shared<procgen_client::EventQueue>())) {}

absl::StatusOr<std::unique_ptr<PagePool>> PagePool::Start(
    std::shared_ptr<procgen_client::Client> client, absl::string_view kind,
    const v1::PoolSpec& spec) {
  absl::BitGen random;
  v1::RunPoolRequest request;
  request.mutable_start()->set_pool_id(absl::StrCat(
      kPrefix, kind, "-", absl::Hex(absl::Uniform<uint64_t>(random), absl::kZeroPad16)));
  *request.mutable_start()->mutable_spec() = spec;
  std::unique_ptr<PagePool> pool(new PagePool(std::move(client)));
  absl::StatusOr<v1::RunPoolResponse> started = pool->Call(request);
  if (!started.ok()) {
    return started.status();
  }
  pool->spec_ = std::move(*started->mutable_started()->mutable_pool()->mutable_spec());
  return pool;
}

absl::StatusOr<v1::RunPoolResponse> PagePool::Call(const v1::RunPoolRequest& request) {
  if (absl::Status status = Send(request); !status.ok()) {
    return status;
  }
  return Receive();
}

absl::Status PagePool::Send(const v1::RunPoolRequest& request) {
  while (is_writing_) {
    if (absl::Status status = Advance(); !status.ok()) {
      return status;
    }
  }
  is_writing_ = true;
  stream_->Write(request);
  return absl::OkStatus();
}

absl::StatusOr<v1::RunPoolResponse> PagePool::Receive() {
  while (received_.empty()) {
    if (absl::Status status = Advance(); !status.ok()) {
      return status;
    }
  }
  v1::RunPoolResponse response = std::move(received_.front());
  received_.pop_front();
  return response;
}

absl::Status PagePool::Advance() {
  using Event = procgen_client::RunStream::Event;
  switch (stream_->Next(absl::InfiniteDuration())) {
    case Event::kNone:
      break;
    case Event::kWritten:
      is_writing_ = false;
      break;
    case Event::kResponse: {
      grpc::Slice bytes;
      v1::RunPoolResponse response;
      if (!stream_->response().DumpToSingleSlice(&bytes).ok() ||
          !response.ParseFromArray(bytes.begin(), static_cast<int>(bytes.size()))) {
        return absl::InternalError("a response of RunPool cannot be parsed");
      }
      received_.push_back(std::move(response));
      break;
    }
    case Event::kEnd:
      return stream_->status();
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> PagePool::Draw(int32_t environment, int32_t size_px,
                                           v1::FrameView view) {
  v1::RunPoolRequest request;
  request.mutable_render()->add_environments(environment);
  request.mutable_render()->set_size_px(size_px);
  request.mutable_render()->set_format(v1::FRAME_FORMAT_PNG);
  request.mutable_render()->set_view(view);
  absl::StatusOr<v1::RunPoolResponse> response = Call(request);
  if (!response.ok()) {
    return response.status();
  }
  return std::move(*response->mutable_frames()->mutable_frames(0)->mutable_image());
}

}  // namespace procgen::web
