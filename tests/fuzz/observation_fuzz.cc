// Fuzz target: the C++ client decodes bytes as encoded observations, as a zstd frame or as the
// content of one. An input is one byte that selects stage and format, and the bytes. Aborts if an
// error has an undocumented code, or if rejected bytes change what is decoded next.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "procgen/v1/pools.pb.h"
#include "procgen_client/observation_decoder.h"
#include "server/encoding/compressor.h"
#include "server/encoding/observation_encoder.h"

namespace procgen {
namespace {

using procgen_client::ObservationDecoder;

constexpr int32_t kEnvCount = 2;

void Require(bool holds, absl::string_view claim, const absl::Status& status) {
  if (!holds) {
    std::cerr << "observation_fuzz: " << claim << ": " << status << std::endl;
    std::abort();
  }
}

// Selected by the first byte of an input.
struct Choice {
  explicit Choice(uint8_t byte) : whole_frame((byte & 2) != 0) {
    static constexpr PictureShape kShapes[] = {
        {.rows = 64, .columns = 64, .pixel_bytes = 3},
        {.rows = 19, .columns = 19, .pixel_bytes = 3},
        {.rows = 60, .columns = 20, .pixel_bytes = 1},
        {.rows = 3 * 17, .columns = 17, .pixel_bytes = 1, .stack = 3},
    };
    form = byte >> 2 & 3;
    shape = kShapes[form];
  }

  procgen::v1::Pool Pool() const {
    procgen::v1::Pool pool;
    procgen::v1::PoolSpec& spec = *pool.mutable_spec();
    spec.set_env_count(kEnvCount);
    spec.set_encoding(procgen::v1::ENCODING_DELTA_ZSTD);
    procgen::v1::ObservationFormat& format = *spec.mutable_observation_format();
    format.set_size_px(shape.columns);
    format.set_frame_stack(shape.stack);
    if (form == 2) {
      format.set_layout(procgen::v1::LAYOUT_CHW);
    }
    if (form == 3) {
      format.set_color(procgen::v1::COLOR_GRAYSCALE);
    }
    return pool;
  }

  bool whole_frame;
  int form = 0;
  PictureShape shape;
};

void TryToDecode(const Choice& choice, absl::Span<const uint8_t> bytes) {
  const std::string encoded = choice.whole_frame ? std::string(bytes.begin(), bytes.end())
                                                 : Compressor().Compress(bytes, {});
  ObservationDecoder decoder = ObservationDecoder::Make(choice.Pool()).value();
  ObservationEncoder encoder(choice.shape, kEnvCount);
  std::vector<uint8_t> shown(kEnvCount * choice.shape.bytes(), 7);
  std::vector<uint8_t> decoded(shown.size());
  const auto decode = [&](absl::string_view from) {
    return decoder.Decode(0, kEnvCount, from, absl::MakeSpan(decoded));
  };
  const absl::Status first = decode(encoder.Encode(0, kEnvCount, shown));
  Require(first.ok() && decoded == shown, "encoded observations are decoded", first);

  const absl::Status status = decode(encoded);
  if (status.ok()) {
    return;
  }
  Require(status.code() == absl::StatusCode::kDataLoss ||
              status.code() == absl::StatusCode::kFailedPrecondition,
          "rejected with an undocumented code", status);
  shown.front() = 9;
  const absl::Status second = decode(encoder.Encode(0, kEnvCount, shown));
  Require(second.ok() && decoded == shown, "rejected bytes change nothing", second);
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  if (size > 0) {
    procgen::TryToDecode(procgen::Choice(bytes[0]), {bytes + 1, size - 1});
  }
  return 0;
}
