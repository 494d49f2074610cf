// Fuzz target: requests of the methods that answer once. An input is calls in a row, each a piece
// (fuzzed_server.h): the method's number in kMethods, one byte, and the request's bytes. Aborts
// where an error is one that is not promised, or where the server's own pools do not go on after
// it.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "procgen/v1/states.pb.h"
#include "tests/fuzz/fuzzed_server.h"
#include "tests/fuzz/request_methods.h"
#include "tests/service/raw_call.h"

namespace procgen {
namespace {

constexpr size_t kCallsMax = 8;

void CallAll(const std::vector<Piece>& pieces) {
  FuzzedServer& server = TheFuzzedServer();
  server.ResetPools();
  size_t call_count = 0;
  for (const Piece& piece : pieces) {
    if (piece.bytes.empty() || ++call_count > kCallsMax) {
      continue;
    }
    const size_t method = static_cast<uint8_t>(piece.bytes[0]) % std::size(kMethods);
    // Watch methods send responses without end.
    const size_t response_count_max = method == kWatchNodes || method == kWatchPool ? 1 : SIZE_MAX;
    RequirePromised(
        CallRaw(server.channel(), kMethods[method], {piece.bytes.substr(1)}, "", response_count_max)
            .status);
  }
  // Whatever was asked for, a pool that is there can be saved, and one that is not is not found.
  v1::SaveStatesRequest save;
  save.set_pool("pools/a");
  const absl::Status saved =
      CallRaw(server.channel(), kMethods[kSaveStates], {save.SerializeAsString()}).status;
  Require(saved.ok() || absl::IsNotFound(saved), "a pool goes on", saved);
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::CallAll(procgen::PiecesOf(bytes, size));
  return 0;
}
