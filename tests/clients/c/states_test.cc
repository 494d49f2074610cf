// States as JSON, objects, and variants behind the C ABI.

#include <cstdint>
#include <string>
#include <vector>

#include "envcore/environment/readable_state.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/clients/c/c_pool.h"

namespace procgen {
namespace {

using testing::HasSubstr;

std::string SavedState(ProcgenPool* pool) {
  std::vector<uint8_t> data(1 << 16);
  size_t offsets[2] = {};
  const int32_t environment = 0;
  EXPECT_EQ(procgen_save_states(pool, &environment, 1, data.data(), data.size(), offsets),
            PROCGEN_OK);
  return {data.begin(), data.begin() + static_cast<std::ptrdiff_t>(offsets[1])};
}

const uint8_t* BytesOf(const std::string& text) {
  return reinterpret_cast<const uint8_t*>(text.data());
}

TEST(StatesTest, AStateIsConvertedToJsonAndBack) {
  const CPool pool = Made(COptions("coinrun"));
  const std::string snapshot = SavedState(pool.get());
  size_t size = 0;
  EXPECT_EQ(procgen_state_to_json(BytesOf(snapshot), snapshot.size(), nullptr, 0, &size),
            PROCGEN_RESOURCE_EXHAUSTED);
  EXPECT_THAT(procgen_error_message(), HasSubstr("capacity is 0 bytes"));
  std::string json(size, ' ');
  ASSERT_EQ(
      procgen_state_to_json(BytesOf(snapshot), snapshot.size(), json.data(), json.size(), &size),
      PROCGEN_OK);
  EXPECT_EQ(json, SnapshotToJson(snapshot).value());
  std::vector<uint8_t> back(snapshot.size());
  ASSERT_EQ(procgen_state_from_json(json.data(), json.size(), back.data(), back.size(), &size),
            PROCGEN_OK)
      << procgen_error_message();
  EXPECT_EQ(std::string(back.begin(), back.end()), snapshot);
}

TEST(StatesTest, BadStatesAreErrors) {
  size_t size = 0;
  EXPECT_EQ(procgen_state_from_json("{", 1, nullptr, 0, &size), PROCGEN_INVALID_ARGUMENT);
  EXPECT_THAT(procgen_error_message(), HasSubstr("the text is not JSON"));
  EXPECT_EQ(procgen_state_from_json(nullptr, 0, nullptr, 0, &size), PROCGEN_INVALID_ARGUMENT);
  EXPECT_EQ(procgen_state_to_json(BytesOf("PGST"), 4, nullptr, 0, &size), PROCGEN_DATA_LOSS);
  EXPECT_EQ(procgen_state_to_json(BytesOf("PGST"), 4, nullptr, 0, nullptr),
            PROCGEN_INVALID_ARGUMENT);
}

TEST(StatesTest, ObjectsOfASliceAreRead) {
  const CPool pool = Made(COptions("maze"));
  std::vector<ProcgenObject> whole(4 * 3);
  std::vector<int32_t> counts(4);
  ASSERT_EQ(procgen_read_objects(pool.get(), 0, 4, 3, whole.data(), counts.data()), PROCGEN_OK);
  EXPECT_THAT(counts, testing::Each(2));
  std::vector<ProcgenObject> part(2 * 3);
  ASSERT_EQ(procgen_read_objects(pool.get(), 1, 2, 3, part.data(), counts.data()), PROCGEN_OK);
  for (size_t i = 0; i < part.size(); ++i) {
    EXPECT_EQ(part[i].kind, whole[i + 3].kind);
    EXPECT_EQ(part[i].x, whole[i + 3].x);
  }
  EXPECT_EQ(part[0].kind, 0);
  EXPECT_EQ(part[1].kind, 2);
  EXPECT_EQ(part[2].kind, -1);
}

TEST(StatesTest, BadSlicesOfObjectsAreErrors) {
  const CPool pool = Made(COptions("maze"));
  std::vector<ProcgenObject> objects(8);
  std::vector<int32_t> counts(8);
  EXPECT_EQ(procgen_read_objects(pool.get(), 3, 2, 1, objects.data(), counts.data()),
            PROCGEN_INVALID_ARGUMENT);
  EXPECT_STREQ(procgen_error_message(), "the slice is 2 environments from 3 on, the pool has 4");
  EXPECT_EQ(procgen_read_objects(pool.get(), 0, 1, 5000, objects.data(), counts.data()),
            PROCGEN_INVALID_ARGUMENT);
  EXPECT_STREQ(procgen_error_message(), "objects_max is 5000, must be in [1, 4096]");
  EXPECT_EQ(procgen_read_objects(pool.get(), 0, 1, 1, nullptr, counts.data()),
            PROCGEN_INVALID_ARGUMENT);
  EXPECT_EQ(procgen_read_objects(pool.get(), 0, -1, 1, objects.data(), counts.data()),
            PROCGEN_INVALID_ARGUMENT);
}

TEST(StatesTest, AVariantIsAnOption) {
  COptions options("maze");
  const CPool exact = Made(options);
  options.variant = "cheese_corner";
  const CPool varied = Made(options);
  ProcgenObject before[2];
  ProcgenObject after[2];
  int32_t count = 0;
  ASSERT_EQ(procgen_read_objects(exact.get(), 0, 1, 2, before, &count), PROCGEN_OK);
  ASSERT_EQ(procgen_read_objects(varied.get(), 0, 1, 2, after, &count), PROCGEN_OK);
  EXPECT_EQ(before[0].x, after[0].x);
  EXPECT_NE(std::pair(before[1].x, before[1].y), std::pair(after[1].x, after[1].y));
  options.variant = "cheese";
  ProcgenPool* pool = nullptr;
  EXPECT_EQ(procgen_pool_create(&options, &pool), PROCGEN_INVALID_ARGUMENT);
  EXPECT_THAT(procgen_error_message(),
              testing::StartsWith("variant is cheese, must be one of coin_random (coinrun), "));
}

}  // namespace
}  // namespace procgen
