#ifndef ENVCORE_TRACE_TRACE_H_
#define ENVCORE_TRACE_TRACE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "envcore/environment/environment_options.h"
#include "envcore/status/status.h"

namespace procgen {

// A recorded run of E environments over T steps: actions and observed results. Row 0 of the results
// is after creation, row t + 1 after the actions of row t. File format: one line of JSON, then the
// arrays that it lists, little-endian, without padding (see README.md).
struct Trace {
  std::vector<std::string> games;
  EnvironmentOptions options;
  int32_t env_count = 0;
  int32_t step_count = 0;

  std::vector<int32_t> actions;               // [T, E], -1 ends the episode
  std::vector<float> rewards;                 // [T + 1, E]
  std::vector<uint8_t> first;                 // [T + 1, E]
  std::vector<int32_t> level_seeds;           // [T + 1, E]
  std::vector<int32_t> prev_level_seeds;      // [T + 1, E]
  std::vector<uint8_t> prev_level_complete;   // [T + 1, E]
  std::vector<uint32_t> observation_digests;  // [T + 1, E], FNV-1a; or empty
  // Fingerprints of the episodes that ended, in order, per environment: [E] lists, or empty. See
  // class Fingerprint.
  std::vector<std::vector<uint64_t>> fingerprints;

  // Whether the observation digests can be compared with a replay. Recordings drawn without an art
  // folder are always comparable, others only if the player draws `with_upstream_art`.
  bool HasComparablePictures(bool with_upstream_art) const {
    const bool is_flat = options.use_monochrome_assets && !options.use_backgrounds;
    return !observation_digests.empty() &&
           (is_flat || options.use_generated_assets || with_upstream_art);
  }
};

// Reads a trace file. Errors: NOT_FOUND: no such file. DATA_LOSS: not a complete trace (the message
// says what is wrong).
StatusOr<Trace> ReadTrace(const std::string& path);
// Parses the contents of a trace file. The contents may be untrusted: memory is bounded by a small
// multiple of their size.
StatusOr<Trace> ParseTrace(absl::string_view contents);

// Returns the contents of a trace file. REQUIRES: the arrays have the sizes given by env_count and
// step_count.
std::string TraceFileOf(const Trace& trace);

// The digest of an observation: 32-bit FNV-1a of its bytes.
uint32_t ObservationDigest(const uint8_t* bytes, size_t size);

}  // namespace procgen

#endif  // ENVCORE_TRACE_TRACE_H_
