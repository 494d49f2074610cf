#include "server/pool/episodes/annotation_recording.h"

#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::NanSensitiveFloatEq;
using testing::SizeIs;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

void Add(AnnotationRecording* recording, int32_t step, const std::string& name,
         const std::vector<float>& values) {
  const StepAnnotation annotation = {name, values};
  const int64_t expected =
      recording->bytes() + recording->GrowthBytes(step, absl::MakeConstSpan(&annotation, 1));
  recording->Add(step, absl::MakeConstSpan(&annotation, 1));
  EXPECT_EQ(recording->bytes(), expected) << "step " << step;
}

TEST(AnnotationRecordingTest, ASeriesHasARowForEachStepSinceItsFirst) {
  AnnotationRecording recording;
  Add(&recording, 3, "value", {1});
  Add(&recording, 4, "value", {2});
  Add(&recording, 7, "value", {5});
  Add(&recording, 7, "probabilities", {0.25F, 0.75F});
  const std::vector<AnnotationSeries> series = recording.Read();
  ASSERT_THAT(series, SizeIs(2));
  EXPECT_EQ(series[0].name, "value");
  EXPECT_EQ(series[0].value_count, 1);
  EXPECT_EQ(series[0].first_step, 3);
  EXPECT_THAT(series[0].values,
              ElementsAre(1, 2, NanSensitiveFloatEq(kNaN), NanSensitiveFloatEq(kNaN), 5));
  EXPECT_EQ(series[1].first_step, 7);
  EXPECT_THAT(series[1].values, ElementsAre(0.25F, 0.75F));
}

TEST(AnnotationRecordingTest, AnotherNumberOfValuesBeginsTheSeriesAgain) {
  AnnotationRecording recording;
  Add(&recording, 0, "x", {1});
  Add(&recording, 1, "x", {2, 3});
  const std::vector<AnnotationSeries> series = recording.Read();
  ASSERT_THAT(series, SizeIs(1));
  EXPECT_EQ(series[0].first_step, 1);
  EXPECT_THAT(series[0].values, ElementsAre(2, 3));
}

TEST(AnnotationRecordingTest, ClearedRowsKeepTheirMemoryForTheNextEpisode) {
  AnnotationRecording recording;
  for (int32_t step = 0; step < 100; ++step) {
    Add(&recording, step, "value", {1});
  }
  Add(&recording, 5, "once", {1});
  const int64_t bytes = recording.bytes();
  recording.ClearRows();
  EXPECT_THAT(recording.Read(), IsEmpty());
  EXPECT_EQ(recording.bytes(), bytes);
  for (int32_t step = 0; step < 100; ++step) {
    Add(&recording, step, "value", {1});
  }
  EXPECT_EQ(recording.bytes(), bytes);
  recording.ClearRows();  // "once" was not used again
  EXPECT_LT(recording.bytes(), bytes);
}

TEST(AnnotationRecordingTest, TheOlderHalfIsDroppedWithItsMemory) {
  AnnotationRecording recording;
  for (int32_t step = 0; step < 10; ++step) {
    Add(&recording, step, "value", {static_cast<float>(step)});
  }
  const int64_t bytes = recording.bytes();
  recording.DropOlderHalf();
  EXPECT_LT(recording.bytes(), bytes);
  const std::vector<AnnotationSeries> series = recording.Read();
  EXPECT_EQ(series[0].first_step, 5);
  EXPECT_THAT(series[0].values, ElementsAre(5, 6, 7, 8, 9));
  for (int i = 0; i < 4; ++i) {
    recording.DropOlderHalf();
  }
  EXPECT_EQ(recording.bytes(), 0);
}

TEST(AnnotationRecordingTest, NamesAreBounded) {
  AnnotationRecording recording;
  const float value = 1;
  for (int i = 0; i < 100; ++i) {
    const std::string name = absl::StrCat("name ", i);
    const StepAnnotation annotation = {name, absl::MakeConstSpan(&value, 1)};
    recording.Add(i, absl::MakeConstSpan(&annotation, 1));
  }
  EXPECT_THAT(recording.Read(), SizeIs(AnnotationRecording::kSeriesMax));
}

}  // namespace
}  // namespace procgen
