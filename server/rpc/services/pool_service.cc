#include "server/rpc/services/pool_service.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/grpc/refused_stream.h"
#include "server/rpc/pause/pause_pool_reactor.h"
#include "server/rpc/run/run_pool_reactor.h"
#include "server/rpc/services/episode_call.h"
#include "server/rpc/watch/watch_pool_reactor.h"
#include "server/wire/convert_episode.h"
#include "server/wire/convert_history.h"
#include "server/wire/convert_pool.h"

namespace procgen {
namespace {

constexpr int32_t kPageSizeMax = 1000;

absl::Status ListPage(const PoolSupervisor& supervisor, absl::string_view owner,
                      const v1::ListPoolsRequest& request, v1::ListPoolsResponse* response) {
  if (request.page_size() < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("page_size is ", request.page_size(), ", allowed: 0 to ", kPageSizeMax));
  }
  // A token is the number of the last listed pool.
  int64_t after = 0;
  if (!request.page_token().empty() &&
      (!absl::SimpleAtoi(request.page_token(), &after) || after < 1)) {
    return absl::InvalidArgumentError("page_token is not from an earlier response");
  }
  const int32_t size = request.page_size() == 0 || request.page_size() > kPageSizeMax
                           ? kPageSizeMax
                           : request.page_size();
  // One more than requested, to detect whether there is another page.
  std::vector<PoolSupervisor::Numbered> pools =
      supervisor.List(owner, after, static_cast<size_t>(size) + 1);
  if (pools.size() > static_cast<size_t>(size)) {
    pools.pop_back();
    response->set_next_page_token(absl::StrCat(pools.back().number));
  }
  for (const PoolSupervisor::Numbered& numbered : pools) {
    *response->add_pools() = PoolMessageOf(*numbered.pool);
  }
  return absl::OkStatus();
}

absl::Status ReadEpisodes(const PoolSupervisor& supervisor, absl::string_view owner,
                          const v1::ListEpisodesRequest& request,
                          v1::ListEpisodesResponse* response) {
  if (request.after() < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("after is ", request.after(), ", allowed: at least 0"));
  }
  const absl::StatusOr<std::shared_ptr<PoolSession>> pool = supervisor.Find(owner, request.pool());
  if (pool.ok()) {
    FillEpisodeList((*pool)->recent_episodes().ReadList(request.after()), response);
  }
  return pool.status();
}

absl::Status ReadHistory(const PoolSupervisor& supervisor, absl::string_view owner,
                         const v1::GetPoolHistoryRequest& request, v1::PoolHistory* response) {
  const absl::StatusOr<absl::Duration> span = HistorySpanOf(request);
  if (!span.ok()) {
    return span.status();
  }
  const absl::StatusOr<std::shared_ptr<PoolSession>> pool = supervisor.Find(owner, request.name());
  if (!pool.ok()) {
    return pool.status();
  }
  FillHistory((*pool)->history().Read(*span), response);
  const auto bytes = static_cast<int64_t>(response->ByteSizeLong());
  if (const int64_t bytes_max = supervisor.limits().response_bytes_max; bytes > bytes_max) {
    return absl::ResourceExhaustedError(absl::StrCat("the history takes ", bytes,
                                                     " bytes, limit response_bytes_max is ",
                                                     bytes_max, "; ask for a shorter span"));
  }
  return absl::OkStatus();
}

}  // namespace

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* PoolServiceImpl::RunPool(
    grpc::CallbackServerContext* context) {
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  if (!caller.ok()) {
    return new RefusedStream<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>>(
        accounting_->EndCall("PoolService/RunPool", caller.status()));
  }
  return RunPoolReactor::Start(supervisor_, accounting_, context, *std::move(caller));
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* PoolServiceImpl::WatchPool(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  if (!caller.ok()) {
    return new RefusedStream<grpc::ServerWriteReactor<grpc::ByteBuffer>>(
        accounting_->EndCall("PoolService/WatchPool", caller.status()));
  }
  return WatchPoolReactor::Start(supervisor_, &publishers_, accounting_, *std::move(caller),
                                 *request);
}

grpc::ServerUnaryReactor* PoolServiceImpl::GetPool(grpc::CallbackServerContext* context,
                                                   const v1::GetPoolRequest* request,
                                                   v1::Pool* response) {
  return accounting_->Answer(context, "PoolService/GetPool", [&](const std::string& owner) {
    const absl::StatusOr<std::shared_ptr<PoolSession>> pool =
        supervisor_->Find(owner, request->name());
    if (pool.ok()) {
      *response = PoolMessageOf(**pool);
    }
    return pool.status();
  });
}

grpc::ServerUnaryReactor* PoolServiceImpl::ListPools(grpc::CallbackServerContext* context,
                                                     const v1::ListPoolsRequest* request,
                                                     v1::ListPoolsResponse* response) {
  return accounting_->Answer(context, "PoolService/ListPools", [&](const std::string& owner) {
    return ListPage(*supervisor_, owner, *request, response);
  });
}

grpc::ServerUnaryReactor* PoolServiceImpl::GetEpisode(grpc::CallbackServerContext* context,
                                                      const v1::GetEpisodeRequest* request,
                                                      v1::Episode* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  if (!caller.ok()) {
    reactor->Finish(accounting_->EndCall("PoolService/GetEpisode", caller.status()));
    return reactor;
  }
  // A copy of the owner, because the caller is moved.
  const std::string owner = caller->owner;
  FetchEpisode(supervisor_, owner, *request, response,
               [this, reactor, caller = *std::move(caller)](const absl::Status& status) {
                 reactor->Finish(accounting_->EndCall("PoolService/GetEpisode", status));
               });
  return reactor;
}

grpc::ServerUnaryReactor* PoolServiceImpl::ListEpisodes(grpc::CallbackServerContext* context,
                                                        const v1::ListEpisodesRequest* request,
                                                        v1::ListEpisodesResponse* response) {
  return accounting_->Answer(context, "PoolService/ListEpisodes", [&](const std::string& owner) {
    return ReadEpisodes(*supervisor_, owner, *request, response);
  });
}

grpc::ServerUnaryReactor* PoolServiceImpl::GetPoolHistory(grpc::CallbackServerContext* context,
                                                          const v1::GetPoolHistoryRequest* request,
                                                          v1::PoolHistory* response) {
  return accounting_->Answer(context, "PoolService/GetPoolHistory", [&](const std::string& owner) {
    return ReadHistory(*supervisor_, owner, *request, response);
  });
}

grpc::ServerBidiReactor<v1::PausePoolRequest, v1::PausePoolResponse>* PoolServiceImpl::PausePool(
    grpc::CallbackServerContext* context) {
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  if (!caller.ok()) {
    return new RefusedStream<grpc::ServerBidiReactor<v1::PausePoolRequest, v1::PausePoolResponse>>(
        accounting_->EndCall("PoolService/PausePool", caller.status()));
  }
  return PausePoolReactor::Start(supervisor_, accounting_, *std::move(caller));
}

}  // namespace procgen
