// A program with a race that ThreadSanitizer must report. It proves that the annotations of this
// folder hide no race of ours. Its argument selects the race:
//
//   callback  between a server's reactor, on a thread of gRPC, and a client's thread
//   mutex     between two threads that hold different locks

#include <memory>
#include <string_view>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/generic/async_generic_service.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server_builder.h"
#include "tests/service/raw_call.h"

namespace procgen {
namespace {

int unguarded_count = 0;

void CountUnguarded() { ++unguarded_count; }

// Reads one message, counts it and ends the call.
class CountingReactor final : public grpc::ServerGenericBidiReactor {
 public:
  CountingReactor() { StartRead(&request_); }

 private:
  void OnReadDone(bool /*ok*/) override {
    CountUnguarded();
    Finish(grpc::Status::OK);
  }
  void OnDone() override { delete this; }

  grpc::ByteBuffer request_;
};

class CountingService final : public grpc::CallbackGenericService {
 private:
  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* /*context*/) override {
    return new CountingReactor;
  }
};

void RaceWithCallback() {
  CountingService service;
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterCallbackGenericService(&service);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  const std::shared_ptr<grpc::Channel> channel =
      grpc::CreateChannel(absl::StrCat("127.0.0.1:", port), grpc::InsecureChannelCredentials());
  std::thread caller([&channel] { CallRaw(channel, "/any.Service/Method", {"request"}); });
  CountUnguarded();
  caller.join();
  server->Shutdown();
}

void RaceBesideMutexes() {
  absl::Mutex first_mutex;
  absl::Mutex second_mutex;
  std::thread other([&first_mutex] {
    absl::MutexLock lock(&first_mutex);
    CountUnguarded();
  });
  {
    absl::MutexLock lock(&second_mutex);
    CountUnguarded();
  }
  other.join();
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  const std::string_view place = argc == 2 ? argv[1] : "";
  if (place == "callback") {
    procgen::RaceWithCallback();
  } else if (place == "mutex") {
    procgen::RaceBesideMutexes();
  } else {
    return 2;
  }
  return 0;
}
