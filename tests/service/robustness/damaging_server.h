#ifndef TESTS_SERVICE_ROBUSTNESS_DAMAGING_SERVER_H_
#define TESTS_SERVICE_ROBUSTNESS_DAMAGING_SERVER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "grpcpp/channel.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "procgen/v1/step.grpc.pb.h"

namespace procgen {

// A proxy between a learner and a real server. It changes the response to one request (0: attach),
// and may send an additional response before it. REQUIRES: each request has exactly one response,
// and is sent after the previous response.
class DamagingServer final : public v1::StepService::Service {
 public:
  using Damage = std::function<void(v1::StepPoolResponse*)>;

  DamagingServer(const std::shared_ptr<grpc::Channel>& target, int64_t number, Damage damage,
                 std::optional<v1::StepPoolResponse> sent_before = std::nullopt)
      : target_(v1::StepService::NewStub(target)),
        number_(number),
        damage_(std::move(damage)),
        sent_before_(std::move(sent_before)) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address_ = absl::StrCat("127.0.0.1:", port);
  }

  const std::string& address() const { return address_; }

  grpc::Status StepPool(
      grpc::ServerContext* /*context*/,
      grpc::ServerReaderWriter<v1::StepPoolResponse, v1::StepPoolRequest>* learner) override {
    grpc::ClientContext context;
    const auto stream = target_->StepPool(&context);
    v1::StepPoolRequest request;
    v1::StepPoolResponse response;
    while (learner->Read(&request) && stream->Write(request) && stream->Read(&response)) {
      if (response.sequence_number() == number_) {
        if (sent_before_.has_value()) {
          learner->Write(*sent_before_);
        }
        damage_(&response);
      }
      learner->Write(response);
    }
    stream->WritesDone();
    return stream->Finish();
  }

 private:
  const std::unique_ptr<v1::StepService::Stub> target_;
  const int64_t number_;
  const Damage damage_;
  const std::optional<v1::StepPoolResponse> sent_before_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_DAMAGING_SERVER_H_
