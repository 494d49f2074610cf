#include "procgen_client/internal/answer_validation.h"

#include <numeric>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

// Bounds of the API: PoolSpec.total_env_count, the largest observation that ObservationFormat
// allows, and State.snapshot.
constexpr int32_t kEnvCountMax = 16777216;
constexpr int64_t kObservationBytesMax = int64_t{16} * 512 * 512 * 3;
constexpr size_t kSnapshotBytesMax = 1 << 20;
constexpr int32_t kFrameSizePxMax = 2048;
constexpr absl::string_view kPngSignature = "\x89PNG\r\n\x1a\n";

absl::Status Wrong(absl::string_view what) {
  return absl::InternalError(absl::StrCat("the server's answer: ", what));
}

}  // namespace

absl::Status ValidatePool(const v1::Pool& pool, const std::string& name) {
  if (pool.name() != name) {
    return Wrong(absl::StrCat("pool '", pool.name(), "', expected: '", name, "'"));
  }
  if (pool.spec().env_count() < 1 || pool.spec().env_count() > kEnvCountMax) {
    return Wrong(absl::StrCat("a pool of ", pool.spec().env_count(),
                              " environments, expected: 1 to ", kEnvCountMax));
  }
  int64_t bytes = 1;
  for (const int32_t size : pool.observation_shape()) {
    bytes =
        size < 1 || size > kObservationBytesMax / bytes ? kObservationBytesMax + 1 : bytes * size;
    if (bytes > kObservationBytesMax) {
      break;
    }
  }
  if (pool.observation_shape().empty() || bytes > kObservationBytesMax ||
      bytes != pool.observation_bytes()) {
    return Wrong(absl::StrCat("observations of ", pool.observation_bytes(),
                              " bytes, expected: the product of their shape, up to ",
                              kObservationBytesMax));
  }
  return absl::OkStatus();
}

absl::Status ValidateCreatedPool(const v1::Pool& pool, const v1::CreatePoolRequest& request) {
  const std::string name =
      request.pool_id().empty() ? pool.name() : absl::StrCat("pools/", request.pool_id());
  if (absl::Status status = ValidatePool(pool, name); !status.ok()) {
    return status;
  }
  if (pool.spec().env_count() != request.spec().env_count()) {
    return Wrong(absl::StrCat("a pool of ", pool.spec().env_count(),
                              " environments, expected: ", request.spec().env_count()));
  }
  return absl::OkStatus();
}

absl::Status ValidateFrames(const google::protobuf::RepeatedPtrField<v1::Frame>& frames,
                            absl::Span<const int32_t> environments, int32_t size_px,
                            v1::FrameFormat format) {
  if (frames.size() != static_cast<int>(environments.size())) {
    return Wrong(absl::StrCat(frames.size(), " frames, expected: ", environments.size()));
  }
  for (int i = 0; i < frames.size(); ++i) {
    const v1::Frame& frame = frames[i];
    const int32_t environment = environments[static_cast<size_t>(i)];
    if (frame.environment() != environment) {
      return Wrong(absl::StrCat("a frame of environment ", frame.environment(),
                                ", expected: ", environment));
    }
    const int64_t size = frame.size_px();
    if (size < 1 || size > kFrameSizePxMax || (size_px != 0 && size != size_px)) {
      return Wrong(absl::StrCat("a frame of ", size, " x ", size, " pixels, expected: a square of ",
                                size_px == 0 ? "1 to 2048" : absl::StrCat(size_px)));
    }
    const std::string& image = frame.image();
    if (format == v1::FRAME_FORMAT_PNG ? !absl::StartsWith(image, kPngSignature)
                                       : static_cast<int64_t>(image.size()) != size * size * 3) {
      return Wrong(absl::StrCat(
          "a frame in ", image.size(), " bytes, expected: ",
          format == v1::FRAME_FORMAT_PNG ? "a PNG file" : absl::StrCat(size * size * 3)));
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateStates(const v1::SaveStatesResponse& page,
                            absl::Span<const int32_t> environments, size_t before) {
  const size_t count_max = environments.empty() ? size_t{kEnvCountMax} : environments.size();
  const size_t count = before + static_cast<size_t>(page.states_size());
  const bool is_last = page.next_page_token().empty();
  const bool is_incomplete = is_last && !environments.empty() && count < count_max;
  if (page.states().empty() || count > count_max || is_incomplete ||
      (!is_last && count == count_max)) {
    return Wrong(absl::StrCat(
        page.states_size(), " states after ", before, is_last ? "" : " and more to come",
        ", expected: ", environments.empty() ? "at least 1" : absl::StrCat(count_max), " in all"));
  }
  for (int i = 0; i < page.states_size(); ++i) {
    const v1::State& state = page.states(i);
    const size_t at = before + static_cast<size_t>(i);
    const int32_t environment = environments.empty() ? static_cast<int32_t>(at) : environments[at];
    if (state.environment() != environment) {
      return Wrong(absl::StrCat("a state of environment ", state.environment(),
                                ", expected: ", environment));
    }
    if (state.snapshot().empty() || state.snapshot().size() > kSnapshotBytesMax) {
      return Wrong(absl::StrCat("a snapshot of ", state.snapshot().size(),
                                " bytes, expected: 1 to ", kSnapshotBytesMax));
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateEpisode(const v1::Episode& episode, int32_t environment) {
  if (episode.environment() != environment) {
    return Wrong(absl::StrCat("an episode of environment ", episode.environment(),
                              ", expected: ", environment));
  }
  const auto actions = static_cast<int64_t>(episode.actions().size());
  for (const v1::LevelChange& change : episode.level_changes()) {
    if (change.action() < 0 || change.action() >= actions) {
      return Wrong(absl::StrCat("a level that begins with action ", change.action(),
                                ", expected: one of ", actions));
    }
  }
  const auto& counts = episode.action_counts();
  const int64_t steps = counts.empty() ? actions : counts.size();
  const int64_t taken =
      counts.empty() ? actions : std::accumulate(counts.begin(), counts.end(), int64_t{0});
  if (episode.incomplete_reason() == v1::INCOMPLETE_REASON_UNSPECIFIED &&
      (episode.rewards_size() != steps || taken != actions)) {
    return Wrong(absl::StrCat(episode.rewards_size(), " rewards of ", steps, " steps with ", taken,
                              " actions, expected: one a step, and ", actions, " actions"));
  }
  return absl::OkStatus();
}

}  // namespace procgen_client
