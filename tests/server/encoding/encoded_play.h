#ifndef TESTS_SERVER_ENCODING_ENCODED_PLAY_H_
#define TESTS_SERVER_ENCODING_ENCODED_PLAY_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"
#include "procgen/v1/pools.pb.h"
#include "server/session/backend/observation_coding.h"

namespace procgen {

// A game, and the format of its observations.
struct EncodedPlayOptions {
  std::string game;
  DistributionMode mode = DistributionMode::kHard;
  ObservationFormat format = {};
  int32_t env_count = 4;
  int worker_count = 1;  // including the calling thread
};

// The observations of one response.
struct EncodedAnswer {
  int32_t first = 0;
  int32_t count = 0;
  std::string encoded;
  std::vector<uint8_t> observations;  // the raw observations  uint8 [count, F]
};

// Steps a pool with random actions that also end episodes, and encodes random slices. Equal options
// give equal results. Threads: one thread at a time.
class EncodedPlay {
 public:
  explicit EncodedPlay(const EncodedPlayOptions& options);

  // Steps all environments and encodes the observations of a random slice.
  EncodedAnswer Next();
  // The pool's message, as the server returns it.
  procgen::v1::Pool pool() const;

 private:
  const EncodedPlayOptions options_;
  std::unique_ptr<Pool> pool_;
  std::unique_ptr<ObservationEncoder> encoder_;
  RandomStream random_;
  std::vector<uint8_t> observations_;
};

}  // namespace procgen

#endif  // TESTS_SERVER_ENCODING_ENCODED_PLAY_H_
