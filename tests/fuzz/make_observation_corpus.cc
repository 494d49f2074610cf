// procgen-make-observation-corpus FOLDER: writes the seed inputs of observation_fuzz to
// FOLDER/<stage>_zstd_<form>: encoded observations after the first one, complete and without their
// last stage. Overwrites existing files.

#include <cstdint>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "procgen_client/internal/frame_content.h"
#include "server/encoding/observation_encoder.h"

namespace {

constexpr int kBadUse = 2;
constexpr int32_t kEnvCount = 2;
constexpr size_t kContentBytesMax = 1 << 20;

// The formats of observation_fuzz.
constexpr procgen::PictureShape kShapes[] = {
    {.rows = 64, .columns = 64, .pixel_bytes = 3},
    {.rows = 19, .columns = 19, .pixel_bytes = 3},
    {.rows = 60, .columns = 20, .pixel_bytes = 1},
    {.rows = 3 * 17, .columns = 17, .pixel_bytes = 1, .stack = 3},
};

// A frame of stripes that move with `time`, and a static spot.
std::vector<uint8_t> Stripes(const procgen::PictureShape& shape, int32_t time) {
  std::vector<uint8_t> bytes(kEnvCount * shape.bytes(), 7);
  if (time > 0) {
    for (size_t i = 0; i < bytes.size(); ++i) {
      const size_t row = i / shape.row_bytes();
      bytes[i] = (row + static_cast<size_t>(time)) % 5 == 0 ? static_cast<uint8_t>(i * i) : 7;
    }
  }
  return bytes;
}

bool Write(const std::string& path, uint8_t choice, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file << static_cast<char>(choice) << bytes;
  return static_cast<bool>(file.flush());
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::cerr << "usage: procgen-make-observation-corpus FOLDER\n";
    return kBadUse;
  }
  const std::string folder = std::string(arguments[1]) + "/";
  for (uint8_t form = 0; form < 4; ++form) {
    procgen::ObservationEncoder encoder(kShapes[form], kEnvCount);
    encoder.Encode(0, kEnvCount, Stripes(kShapes[form], 0));
    const std::string frame = encoder.Encode(0, kEnvCount, Stripes(kShapes[form], 1));
    const std::string content = procgen_client::FrameContent(frame, kContentBytesMax).value();
    const auto choice = static_cast<uint8_t>(form << 2);
    const std::string name = absl::StrCat("zstd_", static_cast<int>(form));
    if (!Write(absl::StrCat(folder, "frame_", name), choice | 2, frame) ||
        !Write(absl::StrCat(folder, "content_", name), choice, content)) {
      std::cerr << "procgen-make-observation-corpus: cannot write in " << folder << "\n";
      return kBadUse;
    }
  }
  return 0;
}
