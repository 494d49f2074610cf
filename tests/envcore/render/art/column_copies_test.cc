#include "envcore/render/art/column_copies.h"

#include <array>
#include <cstdint>
#include <thread>
#include <vector>

#include "gtest/gtest.h"

namespace procgen {
namespace {

Image Numbered(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.At(x, y) = {static_cast<uint8_t>(x), static_cast<uint8_t>(x >> 8),
                        static_cast<uint8_t>(y), 255};
    }
  }
  return image;
}

const Image* FindOften(const ColumnCopies& copies, const Image& image,
                       const ColumnCopies::Part& part) {
  const Image* found = nullptr;
  for (int i = 0; i < ColumnCopies::kRequestsMin; ++i) {
    found = copies.Find(image, part);
  }
  return found;
}

void ExpectCopy(const Image& copy, const Image& image, const ColumnCopies::Part& part) {
  ASSERT_EQ(copy.width(), part.width);
  ASSERT_EQ(copy.height(), part.end_row - part.first_row);
  for (int y = 0; y < copy.height(); ++y) {
    for (int x = 0; x < copy.width(); ++x) {
      const auto column = static_cast<int>((part.position + x * part.step) >> 16);
      ASSERT_EQ(copy.At(x, y), image.At(column, part.first_row + y)) << x << ", " << y;
    }
  }
}

constexpr ColumnCopies::Part kPart = {
    .position = 70000, .step = 200000, .width = 30, .first_row = 2, .end_row = 9};

TEST(ColumnCopiesTest, CopiesArePreparedWhenTheyAreOftenRequested) {
  const Image image = Numbered(100, 10);
  const ColumnCopies copies;
  for (int i = 1; i < ColumnCopies::kRequestsMin; ++i) {
    EXPECT_EQ(copies.Find(image, kPart), nullptr) << i;
  }
  const Image* copy = copies.Find(image, kPart);
  ASSERT_NE(copy, nullptr);
  ExpectCopy(*copy, image, kPart);
  EXPECT_EQ(copies.Find(image, kPart), copy);
}

TEST(ColumnCopiesTest, PartsThatDifferInOneValueHaveTheirOwnCopies) {
  const Image image = Numbered(200, 10);
  const ColumnCopies copies;
  std::vector<ColumnCopies::Part> parts(6, kPart);
  ++parts[1].position;
  ++parts[2].step;
  ++parts[3].width;
  ++parts[4].first_row;
  ++parts[5].end_row;
  for (const ColumnCopies::Part& part : parts) {
    const Image* copy = FindOften(copies, image, part);
    ASSERT_NE(copy, nullptr);
    ExpectCopy(*copy, image, part);
  }
}

TEST(ColumnCopiesTest, PartsThatAreRequestedOnceAreNotCopied) {
  const Image image = Numbered(200, 10);
  const ColumnCopies copies;
  for (int round = 0; round < ColumnCopies::kRequestsMin; ++round) {
    ColumnCopies::Part part = kPart;
    for (int i = 0; i < 1000; ++i, part.position += 37) {
      EXPECT_EQ(copies.Find(image, part), nullptr);
    }
  }
}

TEST(ColumnCopiesTest, BytesAreBounded) {
  const Image image = Numbered(600, 600);
  const ColumnCopies copies;
  int64_t bytes = 0;
  for (int i = 0; i < 20; ++i) {
    const ColumnCopies::Part part = {
        .position = i, .step = 2 << 16, .width = 250, .first_row = 0, .end_row = 600};
    if (const Image* copy = FindOften(copies, image, part)) {
      bytes += static_cast<int64_t>(sizeof(Rgba)) * copy->width() * copy->height();
    }
  }
  EXPECT_GT(bytes, ColumnCopies::kKeptBytesMax / 3);
  EXPECT_LE(bytes, ColumnCopies::kKeptBytesMax);
}

TEST(ColumnCopiesTest, ThreadsFindTheSamePixels) {
  const Image image = Numbered(200, 10);
  const ColumnCopies copies;
  std::array<std::thread, 4> threads;
  for (std::thread& thread : threads) {
    thread = std::thread([&] {
      for (int i = 0; i < 2000; ++i) {
        ColumnCopies::Part part = kPart;
        part.position += i % 5;
        if (const Image* copy = copies.Find(image, part)) {
          ExpectCopy(*copy, image, part);
        }
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
}

}  // namespace
}  // namespace procgen
