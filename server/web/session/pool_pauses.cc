#include "server/web/session/pool_pauses.h"

#include "absl/strings/str_cat.h"

namespace procgen::web {

absl::StatusOr<Answer> PoolPauses::Do(const Request& request, procgen_client::Client* client) {
  RequestParams params(request.members);
  const std::string name = params.Text("pool");
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  const auto pause = pauses_.find(name);
  if (request.method == "pool.pause" && pause == pauses_.end()) {
    if (absl::Status status = Pause(name, client); !status.ok()) {
      return status;
    }
  } else if (request.method == "pool.step") {
    if (pause == pauses_.end()) {
      return absl::FailedPreconditionError(
          absl::StrCat("this page has not paused pool ", name, "; call pool.pause first"));
    }
    pause->second->Step();
  } else if (request.method == "pool.resume") {
    pauses_.erase(name);
  }
  return Answer();
}

absl::Status PoolPauses::Pause(const std::string& name, procgen_client::Client* client) {
  // Only the owner's client finds the pool.
  const absl::StatusOr<procgen::v1::Pool> pool = client->GetPool(name);
  if (!pool.ok()) {
    return pool.status();
  }
  std::unique_ptr<PoolPause> pause = pause_pool_(pool->owner(), name);
  if (pause == nullptr) {
    return absl::NotFoundError(absl::StrCat("there is no pool ", name, " any more"));
  }
  pauses_[name] = std::move(pause);
  return absl::OkStatus();
}

}  // namespace procgen::web
