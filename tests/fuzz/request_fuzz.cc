// Fuzz target: requests of all methods except RunPool, beside a learner. An input is a sequence of
// calls, each a piece (pieces.h): the method's index in kMethods, one byte, and the request's
// bytes. Aborts if an error is undocumented, or if the learner cannot step its pool afterwards.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/fuzz/fuzzed_server.h"
#include "tests/fuzz/request_methods.h"
#include "tests/service/raw_call.h"

namespace procgen {
namespace {

constexpr size_t kCallsMax = 8;

void CallAll(const std::vector<Piece>& pieces) {
  LivePool& pool = TheLivePool();
  size_t call_count = 0;
  for (const Piece& piece : pieces) {
    if (piece.bytes.empty() || ++call_count > kCallsMax) {
      continue;
    }
    const size_t method = static_cast<uint8_t>(piece.bytes[0]) % std::size(kMethods);
    // A watch sends responses without end.
    const size_t response_count_max = method == kWatchPool ? 1 : SIZE_MAX;
    RequirePromised(CallRaw(TheFuzzedServer().channel(), kMethods[method], {piece.bytes.substr(1)},
                            "", response_count_max)
                        .status);
  }
  pool.Step();
  TheFuzzedServer().RequirePoolCount(1);
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::CallAll(procgen::PiecesOf(bytes, size));
  return 0;
}
