// A recording of Procgen 0.10.7 (format: envcore/trace/trace.h), read in C.
#ifndef TESTS_CLIENTS_LIBENV_RECORDING_H_
#define TESTS_CLIENTS_LIBENV_RECORDING_H_

#include <stdint.h>

#include "tests/clients/libenv/host.h"

struct Recording {
  struct OptionList options;           // of the recorded environments
  int env_count;                       // E
  int step_count;                      // T
  const uint8_t* actions;              // [T, E]; 255: -1
  const float* rewards;                // [T + 1, E]
  const uint8_t* firsts;               // [T + 1, E]
  const int32_t* level_seeds;          // [T + 1, E]
  const int32_t* prev_level_seeds;     // [T + 1, E]
  const uint8_t* prev_level_complete;  // [T + 1, E]
  const uint32_t* picture_digests;     // [T + 1, E], FNV-1a; null without observations
  int has_upstream_art;                // observations were drawn with upstream's art
  char games[64];
  char* content;  // of the file; the arrays are copies out of it
  void* arrays[8];
};

// Ends the program if the file is no recording.
void ReadRecording(const char* path, struct Recording* recording);
void FreeRecording(struct Recording* recording);

#endif  // TESTS_CLIENTS_LIBENV_RECORDING_H_
