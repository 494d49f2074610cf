#include "envcore/environment/fingerprint.h"

#include <string>

#include "gtest/gtest.h"

namespace procgen {
namespace {

// 64-bit FNV-1a, as published by its authors.
uint64_t HashOf(const std::string& bytes) {
  uint64_t hash = 0xcbf29ce484222325U;
  for (const char byte : bytes) {
    hash ^= static_cast<uint8_t>(byte);
    hash *= 0x100000001b3U;
  }
  return hash;
}

TEST(FingerprintTest, IsTheHashOfTheBytesThatTheHeaderDescribes) {
  EnvironmentOptions options;
  options.distribution_mode = DistributionMode::kEasy;
  options.debug_mode = 258;
  options.use_backgrounds = false;
  Fingerprint fingerprint;
  fingerprint.Begin("maze", options);
  std::string bytes("maze\0\0\0\0\0\x02\x01\0\0\x01\0\0\0\0\0\0", 20);
  EXPECT_EQ(fingerprint.value(), HashOf(bytes));

  fingerprint.AddLevel(-2);
  bytes += "L\xfe\xff\xff\xff";
  EXPECT_EQ(fingerprint.value(), HashOf(bytes));

  fingerprint.AddStep(-1, 10, /*level_complete=*/true, /*terminated=*/true, /*truncated=*/false);
  bytes += std::string("S\xff\xff\xff\xff\x00\x00\x20\x41\x03", 10);
  EXPECT_EQ(fingerprint.value(), HashOf(bytes));

  fingerprint.AddEdit(0x01020304);
  bytes += "E\x04\x03\x02\x01";
  EXPECT_EQ(fingerprint.value(), HashOf(bytes));
}

TEST(FingerprintTest, ContainsAVariantOnlyIfThereIsOne) {
  EnvironmentOptions options;
  options.variant = Variant::kCheeseCorner;
  Fingerprint fingerprint;
  fingerprint.Begin("maze", options);
  EXPECT_EQ(fingerprint.value(),
            HashOf(std::string("maze\0\x01\0\0\0\0\0\0\0\x01\x01\0\0\0\0\0V\x02\0\0\0", 25)));
  options.variant = Variant::kGravity;
  options.variant_value = 2;
  Fingerprint other;
  other.Begin("maze", options);
  EXPECT_EQ(other.value(),
            HashOf(std::string("maze\0\x01\0\0\0\0\0\0\0\x01\x01\0\0\0\0\0V\x04\0\0\0"
                               "\0\0\0\x40",
                               29)));
}

}  // namespace
}  // namespace procgen
