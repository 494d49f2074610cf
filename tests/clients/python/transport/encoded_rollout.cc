// Writes what a server would send of a game's observations, and what a client must make of it, for
// the tests of clients in other languages.
//
//   encoded_rollout GAME rgb|grey hwc|chw SIDE STACK ANSWER_COUNT
//
// On standard output, all numbers int32 and little-endian: the size of a procgen.v1.Pool, the Pool;
// then for each answer: first environment, environment count, size of the encoded observations,
// these; and the observations themselves.

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

#include "tests/server/encoding/encoded_play.h"

namespace {

constexpr int kBadUse = 2;
constexpr int kArgumentCount = 7;

void WriteNumber(int32_t number) {
  std::cout.write(reinterpret_cast<const char*>(&number), sizeof(number));
}

void Write(procgen::EncodedPlay& play, int answer_count) {
  const std::string pool = play.pool().SerializeAsString();
  WriteNumber(static_cast<int32_t>(pool.size()));
  std::cout << pool;
  for (int i = 0; i < answer_count; ++i) {
    const procgen::EncodedAnswer answer = play.Next();
    WriteNumber(answer.first);
    WriteNumber(answer.count);
    WriteNumber(static_cast<int32_t>(answer.encoded.size()));
    std::cout << answer.encoded;
    std::cout.write(reinterpret_cast<const char*>(answer.observations.data()),
                    static_cast<std::streamsize>(answer.observations.size()));
  }
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count != kArgumentCount) {
    std::cerr << "usage: encoded_rollout GAME rgb|grey hwc|chw SIDE STACK ANSWER_COUNT\n";
    return kBadUse;
  }
  const auto is = [&](int index, const char* word) {
    return arguments[index] == std::string(word);
  };
  procgen::EncodedPlayOptions options;
  options.game = arguments[1];
  options.format.frame.color = is(2, "grey") ? procgen::Color::kGrayscale : procgen::Color::kRgb;
  options.format.frame.layout = is(3, "chw") ? procgen::Layout::kChw : procgen::Layout::kHwc;
  options.format.frame.size_px = std::atoi(arguments[4]);
  options.format.frame_stack = std::atoi(arguments[5]);
  procgen::EncodedPlay play(options);
  Write(play, std::atoi(arguments[6]));
  return std::cout.flush() ? 0 : 1;
}
