#ifndef TESTS_BENCHMARK_REMOTE_LEARNER_H_
#define TESTS_BENCHMARK_REMOTE_LEARNER_H_

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
#include "tests/benchmark/action_script.h"
#include "tests/benchmark/bare_stream.h"

namespace procgen {

// What is measured over a stream: a game whose steps cost little, in easy mode, so that the stream
// shows; a server in this process with so many workers.
inline constexpr char kStreamGame[] = "bigfish";
inline constexpr int32_t kStreamWorkerCount = 2;

// Such a server, on a free port of loopback, which shares memory with who asks for it.
absl::StatusOr<std::unique_ptr<Server>> StartStreamServer();

struct RemoteCase {
  std::string game = kStreamGame;
  int32_t env_count = 64;
  int requests_in_flight = 1;
  int32_t chunk_count = 1;     // as StreamOptions::chunk_count
  bool shares_memory = false;  // else all is sent
  bool is_compressed = false;  // ENCODING_DELTA_ZSTD; else raw
};

// A connection to a server, a pool of its own on it, and the random actions that it is given.
// Threads: compatible (one thread at a time).
class RemoteLearner {
 public:
  // The environments have gone from their common start to a typical mixture of states.
  static absl::StatusOr<std::unique_ptr<RemoteLearner>> Start(const std::string& address,
                                                              const RemoteCase& remote_case);
  ~RemoteLearner();

  // Steps the pool and waits for the answer. REQUIRES: nothing was sent ahead.
  absl::Status Step();

  // Sends the steps that are sent ahead, all but one of those that may be unanswered.
  absl::Status SendAhead();
  // Sends a step and receives the answer to the oldest.
  absl::Status Exchange();
  // Receives the answers to those that were sent ahead.
  absl::Status ReceiveRest();

  // What goes over the wire for a step. The arrays of a batch are on the wire as they are in
  // memory; the tags around them do not count. REQUIRES: the last answer was to a step.
  StreamShape Shape() const;

 private:
  RemoteLearner(std::unique_ptr<procgen_client::Client> client, const RemoteCase& remote_case);
  absl::Status MakePool();

  const RemoteCase case_;
  // In the order of making: each is used by the next.
  std::unique_ptr<procgen_client::Client> client_;
  std::string pool_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  ActionScript actions_;
  procgen_client::Batch batch_;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_REMOTE_LEARNER_H_
