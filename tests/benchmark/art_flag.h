#ifndef TESTS_BENCHMARK_ART_FLAG_H_
#define TESTS_BENCHMARK_ART_FLAG_H_

#include <memory>

#include "envcore/pool/shared_art.h"

namespace procgen {

// Returns the art of the flag --art_dir; null without the flag. Ends the program with status 2 and
// a message if the art cannot be loaded. REQUIRES: flags are parsed (RunBenchmarks parses them).
std::shared_ptr<const SharedArt> ArtOfFlag();

}  // namespace procgen

#endif  // TESTS_BENCHMARK_ART_FLAG_H_
