#include "tests/conformance/recorded_states.h"

#include <cstdlib>
#include <iostream>

#include "zlib.h"

namespace procgen {
namespace {

using Json = nlohmann::json;

// One row of cells as "KIND" or "KINDxCOUNT" for each run.
std::string EncodeRow(const Grid& grid, int y) {
  std::string text;
  for (int x = 0; x < grid.width();) {
    const int kind = grid.At(x, y);
    int count = 0;
    while (x < grid.width() && grid.At(x, y) == kind) {
      ++x;
      ++count;
    }
    text += (text.empty() ? "" : " ") + std::to_string(kind);
    if (count > 1) {
      text += "x" + std::to_string(count);
    }
  }
  return text;
}

Json EncodeEntity(const Entity& entity) {
  return {entity.x,
          entity.y,
          entity.vx,
          entity.vy,
          entity.rx,
          entity.ry,
          entity.kind,
          entity.image_kind,
          entity.theme,
          entity.layer,
          entity.rotation,
          entity.spin,
          entity.mirrored ? 1 : 0,
          entity.shot_step,
          entity.spawn_step,
          entity.life_time,
          entity.expiry,
          entity.opacity,
          entity.health,
          entity.angle};
}

}  // namespace

std::vector<Json> ReadGzippedJsonLines(const std::string& path) {
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) {
    std::cerr << "cannot read " << path << "\n";
    std::abort();
  }
  std::string text;
  std::vector<char> buffer(1 << 16);
  for (int size = 0;
       (size = gzread(file, buffer.data(), static_cast<unsigned>(buffer.size()))) > 0;) {
    text.append(buffer.data(), static_cast<size_t>(size));
  }
  gzclose(file);
  std::vector<Json> lines;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(Json::parse(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return lines;
}

Json StateOf(const Game& game, bool with_grid) {
  Scene scene;
  game.FillScene(&scene);
  const World& world = game.world();
  Json state = {{"time", game.step_number()},
                {"world", {world.grid.width(), world.grid.height()}},
                {"background", scene.background.index},
                {"background_offset", scene.background.offset},
                {"step_int", world.shared_random}};
  for (const Entity& entity : world.entities) {
    state["entities"].push_back(EncodeEntity(entity));
  }
  if (with_grid) {
    for (int y = 0; y < world.grid.height(); ++y) {
      state["grid"].push_back(EncodeRow(world.grid, y));
    }
  }
  return state;
}

}  // namespace procgen
