#ifndef TESTS_BENCHMARK_LEARNERS_REMOTE_LEARNER_H_
#define TESTS_BENCHMARK_LEARNERS_REMOTE_LEARNER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "procgen/v1/step.pb.h"
#include "procgen_client/batch.h"
#include "procgen_client/client.h"
#include "procgen_client/step_stream.h"
#include "server/rpc/server.h"
#include "tests/benchmark/learners/bare_stream.h"
#include "tests/benchmark/measuring/action_script.h"

namespace procgen {

// The default game, in easy mode, and the workers of the server. Steps of this game are cheap, so
// the cost of the stream is visible.
inline constexpr char kStreamGame[] = "bigfish";
inline constexpr int32_t kStreamWorkerCount = 2;

// Starts a server in this process on a free port of loopback, with shared memory enabled.
absl::StatusOr<std::unique_ptr<Server>> StartStreamServer();

struct RemoteCase {
  std::string game = kStreamGame;
  int32_t env_count = 64;
  int requests_in_flight = 1;
  int32_t chunk_count = 1;     // as StreamOptions::chunk_count
  bool shares_memory = false;  // else all is sent
  bool is_compressed = false;  // ENCODING_DELTA_ZSTD; else raw
};

// A connection to a server with its own pool and random actions.
// Threads: compatible (one thread at a time).
class RemoteLearner {
 public:
  // Creates the pool and steps it until the environments are in a typical mixture of states.
  static absl::StatusOr<std::unique_ptr<RemoteLearner>> Start(const std::string& address,
                                                              const RemoteCase& remote_case);
  ~RemoteLearner();

  // Steps the pool and waits for the response. REQUIRES: nothing was sent ahead.
  absl::Status Step();

  // Sends all but one of the steps that may be unanswered.
  absl::Status SendAhead();
  // Sends a step and receives the response to the oldest.
  absl::Status Exchange();
  // Receives the responses to the steps of SendAhead.
  absl::Status ReceiveRest();

  // Bytes of the arrays that a step sends and receives, without protobuf tags. REQUIRES: the last
  // response was to a step.
  StreamShape Shape() const;

 private:
  RemoteLearner(std::unique_ptr<procgen_client::Client> client, const RemoteCase& remote_case);
  absl::Status MakePool();

  const RemoteCase case_;
  // In the order of construction: each member uses the previous one.
  std::unique_ptr<procgen_client::Client> client_;
  std::string pool_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  ActionScript actions_;
  procgen_client::Batch batch_;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_LEARNERS_REMOTE_LEARNER_H_
