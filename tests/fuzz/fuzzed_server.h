#ifndef TESTS_FUZZ_FUZZED_SERVER_H_
#define TESTS_FUZZ_FUZZED_SERVER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "grpcpp/grpcpp.h"
#include "server/cluster/cluster.h"
#include "server/rpc/caller.h"
#include "server/rpc/connections.h"
#include "server/rpc/services.h"
#include "server/session/sessions.h"

namespace procgen {

// Aborts with `claim` unless it holds.
void Require(bool holds, absl::string_view claim, const absl::Status& status = absl::OkStatus());

// The services of a server with small limits, called by TCP. For fuzz targets: one for the whole
// run.
class FuzzedServer {
 public:
  FuzzedServer();

  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  // Makes the pools that inputs begin with, in place of all that there are: "pools/a" (two
  // environments of maze), and "pools/b" (three of coinrun, which must be reset where an episode
  // ends, and whose observations are encoded).
  void ResetPools();
  // Nobody's stream is attached to a pool. Waits for those that are about to end.
  void RequireNoStreams();

 private:
  Metrics metrics_{"fuzzed"};
  Sessions sessions_;
  Connections connections_;
  const Callers callers_;
  const std::unique_ptr<Cluster> cluster_ = Cluster::Alone("fuzzed");
  Services services_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

// The one of this process; never destroyed.
FuzzedServer& TheFuzzedServer();

// An error is one that the contract promises to whoever sends nonsense, with a message that fits.
void RequirePromised(const absl::Status& status);

// Inputs are pieces in a row: two bytes of length, little-endian, and so many bytes, or as many as
// there are. A piece of the greatest length, 65535, has no bytes and is a mark.
struct Piece {
  bool is_mark = false;
  std::string bytes;
};
std::vector<Piece> PiecesOf(const uint8_t* bytes, size_t size);
// Pieces as an input. REQUIRES: each has less than 65535 bytes.
std::string InputOf(const std::vector<Piece>& pieces);

}  // namespace procgen

#endif  // TESTS_FUZZ_FUZZED_SERVER_H_
