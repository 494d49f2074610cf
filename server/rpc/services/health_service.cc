#include "server/rpc/services/health_service.h"

#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/call/one_request_stream.h"
#include "server/rpc/grpc/parse_message.h"

namespace procgen {
namespace {

using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;

constexpr char kCheck[] = "Health/Check";
constexpr char kWatch[] = "Health/Watch";
constexpr size_t kServiceLengthMax = 256;

// Returns the name of the service in a request.
absl::StatusOr<std::string> ServiceOf(const absl::StatusOr<grpc::ByteBuffer>& request) {
  HealthCheckRequest message;
  absl::Status status = request.status();
  if (status.ok()) {
    status = ParseMessage(*request, &message);
  }
  if (!status.ok()) {
    return status;
  }
  if (message.service().size() > kServiceLengthMax) {
    return absl::InvalidArgumentError(absl::StrCat("service has ", message.service().size(),
                                                   " characters, allowed: at most ",
                                                   kServiceLengthMax));
  }
  return std::move(*message.mutable_service());
}

grpc::ByteBuffer ResponseOf(HealthServiceImpl::Status status) {
  HealthCheckResponse response;
  response.set_status(status);
  grpc::ByteBuffer bytes;
  bool own_buffer = false;
  grpc::SerializationTraits<HealthCheckResponse>::Serialize(response, &bytes, &own_buffer);
  return bytes;
}

// A call of Check.
class CheckCall final : public OneRequestStream {
 public:
  CheckCall(const HealthServiceImpl* health, const CallAccounting* accounting)
      : health_(health), accounting_(accounting) {
    ReadRequest(accounting->request_timeout());
  }

 private:
  void OnRequest(absl::StatusOr<grpc::ByteBuffer> request) override {
    const absl::StatusOr<std::string> service = ServiceOf(request);
    if (!service.ok()) {
      Finish(accounting_->EndCall(kCheck, service.status()));
      return;
    }
    const HealthServiceImpl::Status status = health_->StatusOf(*service);
    if (status == HealthCheckResponse::SERVICE_UNKNOWN) {
      Finish(accounting_->EndCall(
          kCheck, absl::NotFoundError("there is no such service; reflection lists all services")));
      return;
    }
    response_ = ResponseOf(status);
    StartWriteAndFinish(&response_, grpc::WriteOptions(), grpc::Status::OK);
  }

  void OnDone() override { delete this; }

  const HealthServiceImpl* const health_;
  const CallAccounting* const accounting_;
  grpc::ByteBuffer response_;
};

}  // namespace

// A stream of Watch. Threads: any method from any thread.
class HealthServiceImpl::Watch final : public LatestStream {
 public:
  Watch(const HealthServiceImpl* health, const CallAccounting* accounting)
      : LatestStream(accounting, kWatch), health_(health) {}
  ~Watch() override = default;

  static ByteStream* Start(const std::shared_ptr<Watch>& watch) {
    watch->Begin(watch);
    return watch.get();
  }

  // Sends the status, if the request has arrived.
  void SendStatus() ABSL_LOCKS_EXCLUDED(mutex_) {
    absl::MutexLock lock(&mutex_);
    if (service_.has_value()) {
      Send([status = health_->StatusOf(*service_)] { return ResponseOf(status); });
    }
  }

 private:
  void OnRequest(absl::StatusOr<grpc::ByteBuffer> request) override {
    absl::StatusOr<std::string> service = ServiceOf(request);
    if (!service.ok()) {
      Close(service.status());
      return;
    }
    {
      absl::MutexLock lock(&mutex_);
      service_ = *std::move(service);
    }
    SendStatus();
  }

  void ReleaseSource() override {}

  const HealthServiceImpl* const health_;
  absl::Mutex mutex_;  // held while a status is sent, so that the last one is the newest
  std::optional<std::string> service_ ABSL_GUARDED_BY(mutex_);
};

HealthServiceImpl::HealthServiceImpl(const CallAccounting* accounting,
                                     std::set<std::string> services)
    : accounting_(accounting), services_(std::move(services)) {
  services_.insert("");
  AddByteMethod("grpc.health.v1.Health/Check", [this](auto* /*context*/) { return BeginCheck(); });
  AddByteMethod("grpc.health.v1.Health/Watch", [this](auto* /*context*/) { return BeginWatch(); });
}

HealthServiceImpl::Status HealthServiceImpl::StatusOf(const std::string& service) const {
  if (!services_.contains(service)) {
    return HealthCheckResponse::SERVICE_UNKNOWN;
  }
  absl::MutexLock lock(&mutex_);
  return is_serving_ ? HealthCheckResponse::SERVING : HealthCheckResponse::NOT_SERVING;
}

ByteStream* HealthServiceImpl::BeginCheck() { return new CheckCall(this, accounting_); }

ByteStream* HealthServiceImpl::BeginWatch() {
  const auto watch = std::make_shared<Watch>(this, accounting_);
  {
    absl::MutexLock lock(&mutex_);
    std::erase_if(watches_, [](const auto& each) { return each.expired(); });
    watches_.push_back(watch);
  }
  return Watch::Start(watch);
}

std::vector<std::shared_ptr<HealthServiceImpl::Watch>> HealthServiceImpl::Watches() const {
  std::vector<std::shared_ptr<Watch>> watches;
  absl::MutexLock lock(&mutex_);
  for (const std::weak_ptr<Watch>& each : watches_) {
    if (std::shared_ptr<Watch> watch = each.lock(); watch != nullptr) {
      watches.push_back(std::move(watch));
    }
  }
  return watches;
}

void HealthServiceImpl::SetServing(bool is_serving) {
  {
    absl::MutexLock lock(&mutex_);
    is_serving_ = is_serving;
  }
  for (const std::shared_ptr<Watch>& watch : Watches()) {
    watch->SendStatus();
  }
}

void HealthServiceImpl::EndWatches() {
  for (const std::shared_ptr<Watch>& watch : Watches()) {
    watch->Close(absl::UnavailableError("the server stops"));
  }
}

}  // namespace procgen
