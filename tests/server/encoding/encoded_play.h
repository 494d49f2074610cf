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

// What is played, and how its observations are encoded.
struct EncodedPlayOptions {
  std::string game;
  DistributionMode mode = DistributionMode::kHard;
  ObservationFormat format = {};
  int32_t env_count = 4;
  int worker_count = 1;  // the calling thread is one of them
};

// What one answer would bear.
struct EncodedAnswer {
  int32_t first = 0;
  int32_t count = 0;
  std::string encoded;
  std::vector<uint8_t> observations;  // what it must be decoded to  uint8 [count, F]
};

// Plays at random, so that episodes end and begin, and asks for slices at random, so that some
// environments are seen seldom and in changing company. Always the same for the same options.
// Threads: compatible (one thread at a time).
class EncodedPlay {
 public:
  explicit EncodedPlay(const EncodedPlayOptions& options);

  // Steps all environments and encodes what a slice of them shows.
  EncodedAnswer Next();
  // The pool as the server would tell it.
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
