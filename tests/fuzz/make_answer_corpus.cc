// procgen-make-answer-corpus ADDRESS FOLDER: writes the seed inputs of answer_fuzz: the responses
// of the server at ADDRESS ("host:port", on this machine) to its learner. Overwrites existing
// files.

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "grpcpp/create_channel.h"
#include "grpcpp/support/client_interceptor.h"
#include "procgen/v1/step.pb.h"
#include "procgen_client/client.h"
#include "tests/fuzz/fuzzed_learner.h"
#include "tests/fuzz/pieces.h"

namespace procgen {
namespace {

constexpr int kBadUse = 2;
constexpr char kPool[] = "pools/answers";

using grpc::experimental::InterceptionHookPoints;

// Appends the responses of a call to `pieces`.
class Recorder final : public grpc::experimental::Interceptor {
 public:
  explicit Recorder(std::vector<Piece>* pieces) : pieces_(pieces) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE)) {
      auto* const message = static_cast<google::protobuf::Message*>(methods->GetRecvMessage());
      if (message != nullptr) {
        pieces_->push_back({false, message->SerializeAsString()});
      }
    }
    methods->Proceed();
  }

 private:
  std::vector<Piece>* const pieces_;
};

class Recorders final : public grpc::experimental::ClientInterceptorFactoryInterface {
 public:
  explicit Recorders(std::vector<Piece>* pieces) : pieces_(pieces) {}

  grpc::experimental::Interceptor* CreateClientInterceptor(
      grpc::experimental::ClientRpcInfo* /*info*/) override {
    return new Recorder(pieces_);
  }

 private:
  std::vector<Piece>* const pieces_;
};

std::vector<Piece> AnswersTo(const std::string& address, LearnerOptions options) {
  std::vector<Piece> pieces;
  std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> recorders;
  recorders.push_back(std::make_unique<Recorders>(&pieces));
  const auto channel = grpc::experimental::CreateCustomChannelWithInterceptors(
      address, grpc::InsecureChannelCredentials(), grpc::ChannelArguments(), std::move(recorders));
  RunLearner(channel, options);
  std::vector<Piece> answers = pieces;
  procgen_client::Client::FromChannel(channel, "")->DeletePool(kPool).IgnoreError();
  return answers;
}

void Write(const std::filesystem::path& path, uint8_t options, const std::vector<Piece>& pieces) {
  std::ofstream(path, std::ios::binary) << static_cast<char>(options) << InputOf(pieces);
}

// For responses of a stream: replaces the path of the shared memory by that of answer_fuzz.
void MoveSharedMemory(std::vector<Piece>* pieces) {
  for (Piece& piece : *pieces) {
    if (v1::StepPoolResponse response;
        response.ParseFromString(piece.bytes) && response.attached().has_shared_memory()) {
      v1::SharedMemory* const memory = response.mutable_attached()->mutable_shared_memory();
      memory->set_path(kSharedPath);
      memory->clear_pipe_transport();
      piece.bytes = response.SerializeAsString();
    }
  }
}

// For raw pools: ends the first environment's episode in each step.
void EndEpisodes(std::vector<Piece>* pieces) {
  for (Piece& piece : *pieces) {
    v1::StepPoolResponse response;
    if (!response.ParseFromString(piece.bytes) || !response.has_batch()) {
      continue;
    }
    v1::Batch* const batch = response.mutable_batch();
    const int64_t number = response.sequence_number();
    if (number >= 2 && number <= 4 && batch->terminated_size() > 0) {
      batch->set_terminated(0, true);
      batch->add_fingerprints(7);
      batch->set_final_observations(batch->observations().substr(
          0, batch->observations().size() / static_cast<size_t>(batch->terminated_size())));
      piece.bytes = response.SerializeAsString();
    }
  }
}

void WriteAll(const std::string& address, const std::filesystem::path& folder) {
  constexpr uint8_t kBeside = 4;
  constexpr uint8_t kResumes = 8;
  for (const auto& [observations, name] :
       {std::pair<uint8_t, std::string>(0, "raw"), {1, "zstd"}, {3, "shared"}}) {
    std::vector<Piece> pieces = AnswersTo(address, LearnerOptions(observations));
    MoveSharedMemory(&pieces);
    Write(folder / name, observations, pieces);
    // Pool, attached and batch; then the connection breaks and another stream attaches.
    Piece again = pieces[1];
    v1::StepPoolResponse attached;
    attached.ParseFromString(again.bytes);
    attached.mutable_attached()->set_next_sequence_number(2);
    again.bytes = attached.SerializeAsString();
    std::vector<Piece> resumed = pieces;
    resumed.insert(resumed.begin() + 3, {{true, ""}, again});
    Write(folder / ("resumed_" + name), static_cast<uint8_t>(observations | kResumes), resumed);
    if (observations == 0) {
      EndEpisodes(&pieces);
      Write(folder / "ended", observations, pieces);
    }
  }
  Write(folder / "beside", kBeside, AnswersTo(address, LearnerOptions(kBeside)));
}

}  // namespace
}  // namespace procgen

int main(int argument_count, char** arguments) {
  if (argument_count != 3) {
    std::cerr << "usage: procgen-make-answer-corpus ADDRESS FOLDER\n";
    return procgen::kBadUse;
  }
  std::filesystem::create_directories(arguments[2]);
  procgen::WriteAll(arguments[1], arguments[2]);
  return 0;
}
