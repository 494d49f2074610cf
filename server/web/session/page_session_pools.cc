// The methods of pools.

#include <string>
#include <utility>
#include <vector>

#include "server/web/session/convert_json.h"
#include "server/web/session/page_session.h"

namespace procgen::web {
namespace {

// Mean returns of a pool in the answer of pools.returns.
constexpr size_t kListedReturnsMax = 60;

}  // namespace

absl::StatusOr<Answer> PageSession::ReadHistory(const Request& request) {
  RequestParams params(request.members);
  const std::string name = params.Text("pool");
  const int32_t span_s =
      params.Integer32Or("span_s", PoolHistory::kSpanSDefault, 1, PoolHistory::kSpanSMax);
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  const absl::StatusOr<procgen::v1::Pool> pool = client_->GetPool(name);
  if (!pool.ok()) {
    return pool.status();
  }
  return Answer{context_.feed->HistoryOf(*pool, span_s), {}};
}

absl::StatusOr<Answer> PageSession::ListReturns(const Request& request) {
  if (absl::Status status = RequestParams(request.members).CheckAll(); !status.ok()) {
    return status;
  }
  const absl::StatusOr<std::vector<procgen::v1::Pool>> pools = client_->ListPools();
  if (!pools.ok()) {
    return pools.status();
  }
  Json list = Json::array();
  for (const procgen::v1::Pool& pool : *pools) {
    list.push_back({{"name", pool.name()},
                    {"mean_returns", context_.feed->ReturnsOf(pool, kListedReturnsMax)}});
  }
  return Answer{{{"pools", std::move(list)}}, {}};
}

absl::StatusOr<Answer> PageSession::ListEpisodes(const Request& request) {
  RequestParams params(request.members);
  const std::string name = params.Text("pool");
  const int64_t after = params.Has("after") ? params.Integer("after", 0, kIdMax) : 0;
  if (absl::Status status = params.CheckAll(); !status.ok()) {
    return status;
  }
  const absl::StatusOr<procgen::v1::Pool> pool = client_->GetPool(name);
  if (!pool.ok()) {
    return pool.status();
  }
  return Answer{EpisodesJson(*pool, context_.report_episodes(pool->owner(), pool->name(), after)),
                {}};
}

absl::StatusOr<Answer> PageSession::ControlPause(const Request& request) {
  return pauses_.Do(request, client_.get());
}

}  // namespace procgen::web
