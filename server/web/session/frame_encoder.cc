#include "server/web/session/frame_encoder.h"

#include <utility>
#include <vector>

#include "absl/hash/hash.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

absl::Span<const uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// Values that are not finite become null.
Json AnnotationsOf(const v1::EnvironmentStep& step) {
  Json annotations = Json::array();
  for (const v1::Annotation& annotation : step.annotations()) {
    const std::vector<float> values(annotation.values().begin(), annotation.values().end());
    annotations.push_back({{"name", annotation.name()}, {"values", values}});
  }
  return annotations;
}

// The members of a part that describe `frame`.
Json DescriptionOf(const v1::Frame& frame) {
  Json members = {{"environment", frame.environment()},
                  {"width", frame.size_px()},
                  {"height", frame.size_px()}};
  if (frame.has_step()) {
    const v1::EnvironmentStep& step = frame.step();
    members["step"] = {{"action", step.has_action() ? Json(step.action()) : Json()},
                       {"reward", step.reward()},
                       {"return", step.episode_return()},
                       {"length", step.episode_length()},
                       {"level_seed", step.level_seed()},
                       {"annotations", AnnotationsOf(step)}};
  }
  if (frame.has_ended_episode()) {
    const v1::EndedEpisode& ended = frame.ended_episode();
    members["ended_episode"] = {{"return", ended.episode_return()},
                                {"length", ended.episode_length()},
                                {"level_seed", ended.level_seed()},
                                {"level_complete", ended.level_complete()},
                                {"truncated", ended.truncated()}};
  }
  return members;
}

}  // namespace

const char* NameOf(FrameEncoding encoding) {
  switch (encoding) {
    case FrameEncoding::kRgb:
      return "rgb";
    case FrameEncoding::kDeflate:
      return "deflate";
    case FrameEncoding::kPng:
      return "png";
  }
  return "";
}

FrameEncoder::FrameEncoder(int64_t watch, FrameEncoding encoding, DifferenceCache* differences)
    : watch_(watch), encoding_(encoding), differences_(differences) {
  if (encoding == FrameEncoding::kDeflate) {
    deflater_.emplace();
  }
}

WireMessage FrameEncoder::Encode(v1::WatchPoolResponse response) {
  std::vector<Part> parts;
  for (v1::Frame& frame : *response.mutable_frames()) {
    std::string image = std::move(*frame.mutable_image());
    if (deflater_.has_value()) {
      image = Deflate(frame.environment(), std::move(image));
    }
    parts.push_back({absl::StrCat("environment-", frame.environment()), NameOf(encoding_),
                     std::move(image), DescriptionOf(frame)});
  }
  return EncodeEvent(
      {{"event", "frames"}, {"watch", watch_}, {"request_count", response.request_count()}}, parts);
}

std::string FrameEncoder::Deflate(int32_t environment, std::string pixels) {
  SentFrame& sent = sent_[environment];
  if (pixels == sent.pixels) {
    return "";
  }
  const size_t hash = absl::HashOf(pixels);
  const DifferenceCache::Key key = {sent.hash, hash};
  std::optional<std::string> difference = differences_->Find(key);
  if (!difference.has_value()) {
    difference = deflater_->Deflate(BytesOf(pixels), BytesOf(sent.pixels));
    differences_->Add(key, *difference);
  }
  sent = {std::move(pixels), hash};
  return *std::move(difference);
}

}  // namespace procgen::web
