#ifndef TESTS_BENCHMARK_LEARNERS_REMOTE_LEARNER_H_
#define TESTS_BENCHMARK_LEARNERS_REMOTE_LEARNER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "procgen_client/pool.h"
#include "server/rpc/server.h"
#include "tests/benchmark/learners/bare_stream.h"
#include "tests/benchmark/measuring/action_script.h"

namespace procgen {

// The default game, in easy mode, and the workers of the server. Steps of this game are cheap, so
// the cost of the stream is visible.
inline constexpr char kStreamGame[] = "bigfish";
inline constexpr int32_t kStreamWorkerCount = 2;

// Starts a server in this process on a free port of loopback.
absl::StatusOr<std::unique_ptr<Server>> StartStreamServer();

struct RemoteCase {
  std::string game = kStreamGame;
  int32_t env_count = 64;
  int requests_in_flight = 1;
};

// A connection to a server with its own pool and random actions.
// Threads: compatible (one thread at a time).
class RemoteLearner {
 public:
  // Creates the pool and steps it until the environments are in a typical mixture of states.
  static absl::StatusOr<std::unique_ptr<RemoteLearner>> Start(const std::string& address,
                                                              const RemoteCase& remote_case);

  // Steps the pool and waits for the response. REQUIRES: nothing was sent ahead.
  absl::Status Step();

  // Sends all but one of the steps that may be unanswered.
  absl::Status SendAhead();
  // Sends a step and receives the response to the oldest.
  absl::Status Exchange();
  // Receives the responses to the steps of SendAhead.
  absl::Status ReceiveRest();

  // Bytes of the arrays that a step sends and receives, without protobuf tags.
  StreamShape Shape() const;

 private:
  // Memory of one response.
  struct Answer {
    std::vector<uint8_t> observations;  // [N, 64, 64, 3]
    BatchNumbers numbers;               // [N]
  };

  explicit RemoteLearner(const RemoteCase& remote_case);
  absl::Status SendStep();
  absl::Status Receive();

  const RemoteCase case_;
  ActionScript actions_;
  std::vector<Answer> answers_;  // [requests in flight], used in turn
  size_t step_ = 0;
  std::unique_ptr<procgen_client::Pool> pool_;  // destroyed first: writes to answers_
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_LEARNERS_REMOTE_LEARNER_H_
