#ifndef TESTS_FUZZ_FUZZED_LEARNER_H_
#define TESTS_FUZZ_FUZZED_LEARNER_H_

#include <cstdint>
#include <memory>

#include "grpcpp/channel.h"

namespace procgen {

// Path of the shared memory in the corpus: a file descriptor that answer_fuzz opens.
inline constexpr char kSharedPath[] = "/proc/self/fd/900";
inline constexpr int kSharedFile = 900;

// Selected by the first byte of an input.
struct LearnerOptions {
  explicit LearnerOptions(uint8_t byte)
      : observations(byte & 3), uses_stream((byte & 4) == 0), resumes((byte & 8) != 0) {}

  int observations;  // 0, 2: raw, 1: zstd, 3: raw, in shared memory
  bool uses_stream;  // False: calls the unary methods.
  bool resumes;      // The stream reconnects after UNAVAILABLE.
};

// Runs a session of the C++ client: creates a pool, and steps it or calls other methods. Continues
// with the next call after an error. Reads every array of every batch. Aborts if the arrays of a
// batch do not match its environments and its pool, if data can be read after an error, or if the
// client does not document the error's code.
void RunLearner(const std::shared_ptr<grpc::Channel>& channel, LearnerOptions options);

}  // namespace procgen

#endif  // TESTS_FUZZ_FUZZED_LEARNER_H_
