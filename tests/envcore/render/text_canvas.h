#ifndef TESTS_ENVCORE_RENDER_TEXT_CANVAS_H_
#define TESTS_ENVCORE_RENDER_TEXT_CANVAS_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// A canvas that shapes are drawn on, as text: '.' untouched, '#' drawn once, '2' twice and so on.
class TextCanvas {
 public:
  explicit TextCanvas(int size_px)
      : size_px_(size_px), counts_(static_cast<size_t>(size_px) * static_cast<size_t>(size_px)) {}

  void operator()(int row, int first, int end) const {
    for (int x = first; x < end; ++x) {
      const int pixel = row * size_px_ + x;
      ++counts_[static_cast<size_t>(pixel)];
    }
  }

  std::string Text() const {
    std::string text = "\n";
    for (size_t i = 0; i < counts_.size(); ++i) {
      text += counts_[i] == 0 ? '.' : counts_[i] == 1 ? '#' : static_cast<char>('0' + counts_[i]);
      if ((i + 1) % static_cast<size_t>(size_px_) == 0) {
        text += '\n';
      }
    }
    return text;
  }

 private:
  int size_px_;
  mutable std::vector<int> counts_;  // a run sink is called as const
};

// An image from text, one row a line, 'a' to 'z' opaque pixels whose red channel is the letter,
// '.' transparent ones.
inline Image ImageOf(const std::vector<std::string_view>& rows) {
  Image image(static_cast<int>(rows[0].size()), static_cast<int>(rows.size()));
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const char letter = rows[static_cast<size_t>(y)][static_cast<size_t>(x)];
      if (letter != '.') {
        image.At(x, y) = {static_cast<uint8_t>(letter), 0, 0, 255};
      }
    }
  }
  return image;
}

// A black frame and its memory. As text: the letters of ImageOf, '.' black, '?' any other color.
class TextFrame {
 public:
  explicit TextFrame(int size_px)
      : size_px_(size_px),
        pixels_(static_cast<size_t>(size_px) * static_cast<size_t>(size_px), Rgba{0, 0, 0, 255}) {}

  Frame frame() { return {pixels_.data(), size_px_}; }
  const Rgba& At(int x, int y) { return *frame().At(x, y); }

  std::string Text() const {
    std::string text = "\n";
    for (size_t i = 0; i < pixels_.size(); ++i) {
      const uint8_t red = pixels_[i].red;
      text += red == 0 ? '.' : red >= 'a' && red <= 'z' ? static_cast<char>(red) : '?';
      if ((i + 1) % static_cast<size_t>(size_px_) == 0) {
        text += '\n';
      }
    }
    return text;
  }

 private:
  int size_px_;
  std::vector<Rgba> pixels_;
};

}  // namespace procgen

#endif  // TESTS_ENVCORE_RENDER_TEXT_CANVAS_H_
