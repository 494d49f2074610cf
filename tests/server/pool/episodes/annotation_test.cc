#include "server/pool/episodes/annotation.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<float> kSix = {0, 1, 2, 3, 4, 5};

auto IsInvalid(const std::string& message) {
  return StatusIs(absl::StatusCode::kInvalidArgument, message);
}

TEST(AnnotationTest, RowsAreCopied) {
  const std::vector<Annotation> annotations = {{"value", absl::MakeConstSpan(kSix).subspan(0, 3)},
                                               {"policy/logits", kSix}};
  ASSERT_THAT(CheckAnnotations(annotations, 3), IsOk());
  std::vector<EnvironmentAnnotation> copies(5);
  CopyAnnotations(annotations, 3, 1, &copies);
  ASSERT_EQ(copies.size(), 2U);
  EXPECT_EQ(copies[0].name, "value");
  EXPECT_THAT(copies[0].values, ElementsAre(1));
  EXPECT_EQ(copies[1].name, "policy/logits");
  EXPECT_THAT(copies[1].values, ElementsAre(2, 3));
}

TEST(AnnotationTest, TooManyAreRejected) {
  const std::vector<std::string> names = {"a", "b", "c", "d", "e", "f", "g", "h", "i",
                                          "j", "k", "l", "m", "n", "o", "p", "q"};
  std::vector<Annotation> annotations;
  annotations.reserve(names.size());
  for (const std::string& name : names) {
    annotations.push_back({name, kSix});
  }
  EXPECT_THAT(CheckAnnotations(annotations, 1),
              IsInvalid("annotations has 17 entries, allowed: at most 16"));
  annotations.pop_back();
  EXPECT_THAT(CheckAnnotations(annotations, 1), IsOk());
}

TEST(AnnotationTest, InvalidNamesAreRejected) {
  const std::string allowed = ", allowed: 1 to 64 letters, digits, spaces and _ - . /";
  EXPECT_THAT(CheckAnnotations({{"", kSix}}, 1),
              IsInvalid("annotations[0].name is '' of 0 bytes" + allowed));
  EXPECT_THAT(CheckAnnotations({{"a\n", kSix}}, 1),
              IsInvalid("annotations[0].name is 'a\\n' of 2 bytes" + allowed));
  EXPECT_THAT(CheckAnnotations({{std::string(64, 'x'), kSix}}, 1), IsOk());
  EXPECT_THAT(CheckAnnotations({{std::string(65, 'x'), kSix}}, 1),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("of 65 bytes")));
  EXPECT_THAT(CheckAnnotations({{"a", kSix}, {"a", kSix}}, 1),
              IsInvalid("annotations[1].name is 'a' again, allowed: each name at most once"));
}

TEST(AnnotationTest, ValuesThatDoNotFitTheSliceAreRejected) {
  const std::string allowed = ", allowed: 1 to 64 for each of the 4 environments of the slice";
  EXPECT_THAT(CheckAnnotations({{"value", kSix}}, 4),
              IsInvalid("annotations[0] 'value' has 6 values" + allowed));
  EXPECT_THAT(CheckAnnotations({{"value", {}}}, 4),
              IsInvalid("annotations[0] 'value' has 0 values" + allowed));
  const std::vector<float> many(65 * 4);
  EXPECT_THAT(CheckAnnotations({{"value", many}}, 4),
              IsInvalid("annotations[0] 'value' has 260 values" + allowed));
}

TEST(AnnotationTest, SaliencyMayHaveAValueForEachPixel) {
  const std::vector<float> map(64 * 64 * 2);
  EXPECT_THAT(CheckAnnotations({{"saliency", map}}, 2), IsOk());
  EXPECT_THAT(CheckAnnotations({{"saliency", map}}, 1),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed: 1 to 4096 for")));
}

}  // namespace
}  // namespace procgen
