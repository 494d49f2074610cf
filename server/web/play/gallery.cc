#include "server/web/play/gallery.h"

#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/web/play/page_pool.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

// Level selection: environment i starts at seed `first` + i.
absl::Status BeginLevels(PagePool* pool, int32_t first, int32_t count) {
  v1::RunPoolRequest request;
  request.mutable_reset()->mutable_slice()->set_env_count(count);
  request.mutable_reset()->set_acknowledge_only(true);
  for (int32_t i = 0; i < count; ++i) {
    v1::Reset* const reset = request.mutable_reset()->add_resets();
    reset->set_environment(i);
    reset->set_level_seed(first + i);
  }
  return pool->Call(request).status();
}

}  // namespace

absl::StatusOr<Answer> GalleryPage(const std::shared_ptr<procgen_client::Client>& client,
                                   const LevelChoice& choice, int32_t count, int32_t size_px,
                                   v1::FrameView view) {
  v1::PoolSpec spec = SpecOf(choice);
  spec.set_env_count(count);
  const absl::StatusOr<std::unique_ptr<PagePool>> pool = PagePool::Start(client, "gallery", spec);
  if (!pool.ok()) {
    return pool.status();
  }
  if (count > 1) {
    if (absl::Status status = BeginLevels(pool->get(), choice.level_seed, count); !status.ok()) {
      return status;
    }
  }
  Answer answer;
  Json level_seeds = Json::array();
  for (int32_t i = 0; i < count; ++i) {
    absl::StatusOr<std::string> png = (*pool)->Draw(i, size_px, view);
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
