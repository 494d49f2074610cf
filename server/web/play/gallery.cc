#include "server/web/play/gallery.h"

#include <string>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "server/web/play/single_env_pool.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

// Level selection: environment i starts at seed `first` + i.
absl::Status BeginLevels(procgen_client::Client* client, const std::string& pool, int32_t first,
                         int32_t count) {
  procgen_client::StreamOptions options;
  options.requests_in_flight_max = 1;
  options.reconnect_timeout = absl::ZeroDuration();
  const auto stream = client->Attach(pool, options);
  if (!stream.ok()) {
    return stream.status();
  }
  v1::StepPoolRequest request;
  request.mutable_reset()->set_observation(v1::OBSERVATION_NONE);
  for (int32_t i = 0; i < count; ++i) {
    v1::Reset* const reset = request.mutable_reset()->add_resets();
    reset->set_environment(i);
    reset->set_level_seed(first + i);
  }
  procgen_client::Batch batch;
  return (*stream)->Call(std::move(request), &batch);
}

}  // namespace

absl::StatusOr<Answer> GalleryPage(procgen_client::Client* client, const LevelChoice& choice,
                                   int32_t count, int32_t size_px, v1::FrameView view) {
  v1::PoolSpec spec = SpecOf(choice);
  spec.set_env_count(count);
  const absl::StatusOr<v1::Pool> pool = MakePagePool(client, "gallery", spec);
  if (!pool.ok()) {
    return pool.status();
  }
  const absl::Cleanup end_pool = [&] { client->DeletePool(pool->name()).IgnoreError(); };
  if (count > 1) {
    if (absl::Status status = BeginLevels(client, pool->name(), choice.level_seed, count);
        !status.ok()) {
      return status;
    }
  }
  Answer answer;
  Json level_seeds = Json::array();
  for (int32_t i = 0; i < count; ++i) {
    absl::StatusOr<std::string> png = DrawPng(client, pool->name(), i, size_px, view);
    if (!png.ok()) {
      return png.status();
    }
    const int32_t level_seed = choice.level_seed + i;
    level_seeds.push_back(level_seed);
    answer.parts.push_back({absl::StrCat("level-", level_seed),
                            "png",
                            *std::move(png),
                            {{"width", size_px}, {"height", size_px}, {"level_seed", level_seed}}});
  }
  answer.result = {{"game", choice.game},
                   {"mode", ModeName(choice.options.distribution_mode())},
                   {"level_seeds", std::move(level_seeds)}};
  return answer;
}

}  // namespace procgen::web
