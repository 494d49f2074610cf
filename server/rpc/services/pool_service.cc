#include "server/rpc/services/pool_service.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/call/unary_call.h"
#include "server/wire/convert_observation.h"
#include "server/wire/convert_pool.h"
#include "server/wire/convert_step.h"

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

absl::Status Renew(const PoolSupervisor& supervisor, absl::string_view owner,
                   const v1::RenewPoolRequest& request, v1::Pool* response) {
  std::optional<absl::Duration> lease_duration;
  if (request.has_lease_duration()) {
    const absl::StatusOr<absl::Duration> given =
        LeaseDurationOf("lease_duration", request.lease_duration(), supervisor.limits());
    if (!given.ok()) {
      return given.status();
    }
    lease_duration = *given;
  }
  const absl::StatusOr<std::shared_ptr<PoolSession>> pool = supervisor.Find(owner, request.name());
  absl::Status status = pool.ok() ? (*pool)->Renew(lease_duration) : pool.status();
  if (status.ok()) {
    *response = PoolMessageOf(**pool);
  }
  return status;
}

// Checks that one observation fits in a response; otherwise the pool would be unusable.
absl::Status CheckAnswersFit(const ObservationCoding& coding, const Limits& limits) {
  return ResponseRowsMax("response_bytes_max", Request(), coding, limits.response_bytes_max)
      .status();
}

// Returns the session options of a pool of `spec`: its lease, encoding and transport.
absl::StatusOr<SessionOptions> SessionOptionsOf(const v1::PoolSpec& spec,
                                                const ObservationFormat& format,
                                                const PoolSupervisor& supervisor) {
  const absl::StatusOr<Encoding> encoding = EncodingOf(spec);
  if (!encoding.ok()) {
    return encoding.status();
  }
  const absl::StatusOr<bool> shares_memory = SharesMemory(spec, supervisor.shares_memory());
  if (!shares_memory.ok()) {
    return shares_memory.status();
  }
  if (!*shares_memory) {
    const ObservationCoding coding(format, *encoding);
    if (absl::Status status = CheckAnswersFit(coding, supervisor.limits()); !status.ok()) {
      return status;
    }
  }
  SessionOptions session_options = {.lease_duration = supervisor.limits().lease_duration_default,
                                    .encoding = *encoding,
                                    .shares_memory = *shares_memory};
  if (spec.has_lease_duration()) {
    const absl::StatusOr<absl::Duration> lease_duration =
        LeaseDurationOf("spec.lease_duration", spec.lease_duration(), supervisor.limits());
    if (!lease_duration.ok()) {
      return lease_duration.status();
    }
    session_options.lease_duration = *lease_duration;
  }
  return session_options;
}

}  // namespace

PoolServiceImpl::PoolServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting)
    : supervisor_(supervisor), accounting_(accounting) {
  AddByteMethod<v1::CreatePoolRequest>([this](auto* context) { return CreatePool(context); });
  AddByteMethod<v1::GetPoolRequest>([this](auto* context) { return GetPool(context); });
  AddByteMethod<v1::ListPoolsRequest>([this](auto* context) { return ListPools(context); });
  AddByteMethod<v1::DeletePoolRequest>([this](auto* context) { return DeletePool(context); });
  AddByteMethod<v1::RenewPoolRequest>([this](auto* context) { return RenewPool(context); });
}

ByteStream* PoolServiceImpl::CreatePool(grpc::CallbackServerContext* context) {
  using Call = UnaryCall<v1::CreatePoolRequest, v1::Pool>;
  return Call::Start(*accounting_, *context, [this](Call* call) {
    const v1::PoolSpec& spec = call->request().spec();
    absl::StatusOr<PoolOptions> options = PoolOptionsOf(spec);
    absl::StatusOr<SessionOptions> session_options =
        options.ok() ? SessionOptionsOf(spec, options->observation_format, *supervisor_)
                     : options.status();
    if (session_options.ok() && options->level_sampler != nullptr) {
      auto held =
          HoldSampler(call->owner(), std::move(options->level_sampler), &supervisor_->quotas());
      if (held.ok()) {
        options->level_sampler = *std::move(held);
      } else {
        session_options = held.status();
      }
    }
    if (!session_options.ok()) {
      call->Finish(session_options.status());
      return;
    }
    supervisor_->Create(call->owner(), call->request().pool_id(), *options, *session_options,
                        [call](absl::StatusOr<std::shared_ptr<PoolSession>> pool) {
                          if (!pool.ok()) {
                            call->Finish(pool.status());
                            return;
                          }
                          *call->response() = PoolMessageOf(**pool);
                          call->Finish(absl::OkStatus());
                        });
  });
}

ByteStream* PoolServiceImpl::GetPool(grpc::CallbackServerContext* context) {
  using Call = UnaryCall<v1::GetPoolRequest, v1::Pool>;
  return Call::Start(*accounting_, *context, [this](Call* call) {
    const absl::StatusOr<std::shared_ptr<PoolSession>> pool =
        supervisor_->Find(call->owner(), call->request().name());
    if (pool.ok()) {
      *call->response() = PoolMessageOf(**pool);
    }
    call->Finish(pool.status());
  });
}

ByteStream* PoolServiceImpl::ListPools(grpc::CallbackServerContext* context) {
  using Call = UnaryCall<v1::ListPoolsRequest, v1::ListPoolsResponse>;
  return Call::Start(*accounting_, *context, [this](Call* call) {
    call->Finish(ListPage(*supervisor_, call->owner(), call->request(), call->response()));
  });
}

ByteStream* PoolServiceImpl::DeletePool(grpc::CallbackServerContext* context) {
  using Call = UnaryCall<v1::DeletePoolRequest, google::protobuf::Empty>;
  return Call::Start(*accounting_, *context, [this](Call* call) {
    call->Finish(supervisor_->Delete(call->owner(), call->request().name()));
  });
}

ByteStream* PoolServiceImpl::RenewPool(grpc::CallbackServerContext* context) {
  using Call = UnaryCall<v1::RenewPoolRequest, v1::Pool>;
  return Call::Start(*accounting_, *context, [this](Call* call) {
    call->Finish(Renew(*supervisor_, call->owner(), call->request(), call->response()));
  });
}

}  // namespace procgen
