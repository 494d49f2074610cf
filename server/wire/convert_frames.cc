#include "server/wire/convert_frames.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/encoding/observation_encoder.h"
#include "server/encoding/png.h"
#include "server/pool/environment_list.h"
#include "server/wire/convert_observation.h"
#include "server/wire/convert_pool.h"
#include "server/wire/enum_value.h"

namespace procgen {
namespace {

// Default sizes of frames.
constexpr int32_t kRenderSizePxDefault = 512;
constexpr int32_t kWatchSizePxDefault = 256;
// Upper bound of the size of a frame, or of a response, without its images, in bytes.
constexpr int64_t kFrameOverheadBytes = 64;
// Limits of a watch: it renders continuously and has a few responses in memory.
constexpr int64_t kWatchResponseBytesMax = 16 << 20;
constexpr size_t kWatchEnvironmentsMax = 64;
constexpr float kFramesPerSecondDefault = 15;
constexpr float kFramesPerSecondMax = 60;
// Largest interval between frames, for very small rates.
constexpr absl::Duration kIntervalMax = absl::Hours(24);

// The frames of a render or watch request.
struct FrameRequest {
  absl::Span<const int32_t> environments;
  int32_t size_px = 0;
  v1::FrameFormat format = v1::FRAME_FORMAT_UNSPECIFIED;
  absl::string_view limit;  // name of response_bytes_max
  int64_t response_bytes_max = 0;
  Encoding encoding = Encoding::kRaw;
  bool with_agent_views = false;
};

// Upper bound of the bytes of an image of this size in a response.
int64_t ImageBytesMax(const FrameRequest& frames, int64_t size_px) {
  switch (frames.format) {
    case v1::FRAME_FORMAT_NONE:
      return 0;
    case v1::FRAME_FORMAT_PNG:
      return PngBytesMax(static_cast<int32_t>(size_px));
    default:
      return EncodedBytesMax(frames.encoding, size_px * size_px * 3);
  }
}

absl::Status CheckSize(const FrameRequest& frames) {
  const int64_t size_px = frames.size_px;
  const int64_t image_bytes =
      ImageBytesMax(frames, size_px) +
      (frames.with_agent_views ? ImageBytesMax(frames, kObservationSizePx) : 0);
  const int64_t frames_max =
      (frames.response_bytes_max - kFrameOverheadBytes) / (image_bytes + kFrameOverheadBytes);
  if (static_cast<int64_t>(frames.environments.size()) > frames_max) {
    return absl::ResourceExhaustedError(
        absl::StrCat("environments has ", frames.environments.size(), " entries, limit ",
                     frames.limit, " = ", frames.response_bytes_max, " has room for ", frames_max,
                     " frames of ", size_px, " x ", size_px, " pixels"));
  }
  return absl::OkStatus();
}

absl::Status CheckFrames(const FrameRequest& frames, const PoolSession& pool) {
  if (!v1::FrameFormat_IsValid(frames.format)) {
    return NoSuchValue("format", frames.format);
  }
  if (frames.size_px < kHumanViewSizePxMin || frames.size_px > kHumanViewSizePxMax) {
    return absl::InvalidArgumentError(absl::StrCat("size_px is ", frames.size_px,
                                                   ", allowed: ", kHumanViewSizePxMin, " to ",
                                                   kHumanViewSizePxMax));
  }
  if (absl::Status status = CheckEnvironmentList(
          {.list = "environments", .environments = frames.environments, .repeats_allowed = true},
          pool.name(), pool.env_count());
      !status.ok()) {
    return status;
  }
  return CheckSize(frames);
}

// Bytes of all images of a frame set.
size_t ImageBytesOf(const WatchSpec& spec) {
  const auto size_px = static_cast<size_t>(spec.size_px);
  return spec.environments.size() * size_px * size_px * 3;
}

absl::Span<const int32_t> SpanOf(const google::protobuf::RepeatedField<int32_t>& list) {
  return absl::MakeConstSpan(list.data(), static_cast<size_t>(list.size()));
}

absl::StatusOr<absl::Duration> IntervalOf(float frames_per_second_max) {
  if (frames_per_second_max == 0) {
    return absl::Seconds(1) / static_cast<double>(kFramesPerSecondDefault);
  }
  if (!(frames_per_second_max > 0 && frames_per_second_max <= kFramesPerSecondMax)) {
    return absl::InvalidArgumentError(absl::StrCat("frames_per_second_max is ",
                                                   frames_per_second_max, ", allowed: above 0 to ",
                                                   kFramesPerSecondMax));
  }
  return std::min(absl::Seconds(1) / static_cast<double>(frames_per_second_max), kIntervalMax);
}

void FillStep(const EnvironmentStep& step, v1::EnvironmentStep* message) {
  if (step.action.has_value()) {
    message->set_action(*step.action);
  }
  message->set_reward(step.reward);
  message->set_episode_return(step.episode_return);
  message->set_episode_length(step.episode_length);
  message->set_level_seed(step.level_seed);
  for (const EnvironmentAnnotation& annotation : step.annotations) {
    v1::Annotation* const added = message->add_annotations();
    added->set_name(annotation.name);
    added->mutable_values()->Add(annotation.values.begin(), annotation.values.end());
  }
}

}  // namespace

RenderSpec RenderSpecOf(const v1::Render& request) {
  const View view = request.view() == v1::FRAME_VIEW_AGENT   ? View::kAgent
                    : request.view() == v1::FRAME_VIEW_LEVEL ? View::kLevel
                                                             : View::kHuman;
  const int32_t size_px_default = view == View::kAgent ? kObservationSizePx : kRenderSizePxDefault;
  return {view, request.size_px() == 0 ? size_px_default : request.size_px()};
}

absl::Status CheckRender(const v1::Render& request, const PoolSession& pool, const Limits& limits) {
  if (!v1::FrameView_IsValid(request.view())) {
    return NoSuchValue("view", request.view());
  }
  const RenderSpec spec = RenderSpecOf(request);
  if (spec.view == View::kAgent && spec.size_px != kObservationSizePx) {
    return absl::InvalidArgumentError(absl::StrCat(
        "size_px is ", spec.size_px, ", allowed with FRAME_VIEW_AGENT: ", kObservationSizePx));
  }
  return CheckFrames({SpanOf(request.environments()), spec.size_px, request.format(),
                      "response_bytes_max", limits.response_bytes_max},
                     pool);
}

absl::StatusOr<WatchSpec> WatchSpecOf(const v1::WatchPoolRequest& request, const PoolSession& pool,
                                      const Limits& limits) {
  const absl::StatusOr<Encoding> encoding = EncodingOf("encoding", request.encoding());
  if (!encoding.ok()) {
    return encoding.status();
  }
  if (request.format() == v1::FRAME_FORMAT_NONE) {
    return absl::InvalidArgumentError(
        "format is FRAME_FORMAT_NONE, allowed in a watch: FRAME_FORMAT_RGB, FRAME_FORMAT_PNG");
  }
  if (*encoding == Encoding::kDeltaZstd && request.format() == v1::FRAME_FORMAT_PNG) {
    return absl::InvalidArgumentError(
        "format is FRAME_FORMAT_PNG, allowed with ENCODING_DELTA_ZSTD: FRAME_FORMAT_RGB");
  }
  const absl::StatusOr<absl::Duration> interval = IntervalOf(request.frames_per_second_max());
  if (!interval.ok()) {
    return interval.status();
  }
  const FrameRequest frames = {
      SpanOf(request.environments()),
      request.size_px() == 0 ? kWatchSizePxDefault : request.size_px(),
      request.format(),
      limits.response_bytes_max < kWatchResponseBytesMax ? "response_bytes_max" : "of a watch",
      std::min(limits.response_bytes_max, kWatchResponseBytesMax),
      *encoding,
      request.with_agent_views()};
  if (frames.with_agent_views &&
      (frames.size_px == kObservationSizePx || *encoding != Encoding::kRaw)) {
    return absl::InvalidArgumentError(
        absl::StrCat("with_agent_views is true with size_px ", frames.size_px, " and encoding ",
                     v1::Encoding_Name(request.encoding()), ", allowed: a size_px other than ",
                     kObservationSizePx, ", and ENCODING_RAW"));
  }
  if (frames.environments.size() > kWatchEnvironmentsMax) {
    return absl::InvalidArgumentError(absl::StrCat("environments has ", frames.environments.size(),
                                                   " entries, allowed: 1 to ",
                                                   kWatchEnvironmentsMax));
  }
  if (absl::Status status = CheckFrames(frames, pool); !status.ok()) {
    return status;
  }
  return WatchSpec{.environments = {frames.environments.begin(), frames.environments.end()},
                   .size_px = frames.size_px,
                   .interval = *interval,
                   .format = *encoding == Encoding::kDeltaZstd       ? kDeltaFormat
                             : frames.format == v1::FRAME_FORMAT_PNG ? v1::FRAME_FORMAT_PNG
                                                                     : v1::FRAME_FORMAT_RGB,
                   .with_steps = request.with_steps(),
                   .with_agent_views = request.with_agent_views()};
}

void WriteFrames(v1::FrameFormat format, google::protobuf::RepeatedPtrField<v1::Frame>* frames) {
  if (format != v1::FRAME_FORMAT_PNG) {
    return;
  }
  const auto png_of = [](const std::string& image, int32_t size_px) {
    return PngOf(absl::MakeConstSpan(reinterpret_cast<const uint8_t*>(image.data()), image.size()),
                 size_px);
  };
  for (v1::Frame& frame : *frames) {
    frame.set_image(png_of(frame.image(), frame.size_px()));
    if (!frame.agent_image().empty()) {
      frame.set_agent_image(png_of(frame.agent_image(), kObservationSizePx));
    }
  }
}

absl::Cord EncodeWatched(int32_t format, FrameSet frame_set) {
  v1::WatchPoolResponse response;
  absl::Cord images;
  for (size_t i = 0; i < frame_set.images.size(); ++i) {
    v1::Frame* frame = response.add_frames();
    frame->set_environment(frame_set.environments[i]);
    frame->set_size_px(frame_set.size_px);
    if (format == kDeltaFormat) {
      images.Append(std::move(frame_set.images[i]));
    } else {
      frame->set_image(std::move(frame_set.images[i]));
    }
    if (!frame_set.agent_images.empty()) {
      frame->set_agent_image(std::move(frame_set.agent_images[i]));
    }
    if (!frame_set.steps.empty() && frame_set.steps[i].has_value()) {
      FillStep(*frame_set.steps[i], frame->mutable_step());
    }
    if (const std::optional<FinishedEpisode>& ended = frame_set.ended_episodes[i]) {
      v1::EndedEpisode* const message = frame->mutable_ended_episode();
      message->set_episode_return(ended->episode_return);
      message->set_episode_length(ended->length);
      message->set_level_seed(ended->level_seed);
      message->set_level_complete(ended->level_complete);
      message->set_truncated(ended->truncated);
    }
  }
  if (format == v1::FRAME_FORMAT_PNG) {
    WriteFrames(v1::FRAME_FORMAT_PNG, response.mutable_frames());
  }
  response.set_request_count(frame_set.request_count);
  FillTimestamp(frame_set.time, response.mutable_render_time());
  absl::Cord encoded(response.SerializeAsString());
  encoded.Append(std::move(images));
  return encoded;
}

DeltaFrameEncoder::DeltaFrameEncoder(const WatchSpec& spec)
    : image_bytes_(ImageBytesOf(spec)), encoder_(/*env_count=*/1, image_bytes_) {}

int64_t DeltaFrameEncoder::BytesOf(const WatchSpec& spec) {
  constexpr int64_t kCopies = 4;  // the last images, the newest, the differences and the encoded
  return kCopies * static_cast<int64_t>(ImageBytesOf(spec));
}

std::string DeltaFrameEncoder::Encode(const absl::Cord& frame_set) {
  const size_t header_bytes = frame_set.size() - image_bytes_;
  std::string images(frame_set.Subcord(header_bytes, image_bytes_));
  v1::WatchPoolResponse images_alone;
  images_alone.set_encoded_images(encoder_.Encode(
      0, 1, absl::MakeConstSpan(reinterpret_cast<const uint8_t*>(images.data()), images.size())));
  // The concatenation of two serialised messages is that of the merged message.
  return absl::StrCat(std::string(frame_set.Subcord(0, header_bytes)),
                      images_alone.SerializeAsString());
}

}  // namespace procgen
