#include "server/pool/session_options.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

absl::Status CheckName(const std::string& display_name) {
  return CheckSessionOptions({.display_name = display_name, .labels = {}});
}

absl::Status CheckLabel(const std::string& key, const std::string& value) {
  return CheckSessionOptions({.display_name = "", .labels = {{key, value}}});
}

TEST(SessionOptionsTest, NamesAreTextWithoutControlCharacters) {
  for (const std::string& name : {std::string(), std::string("bigfish, seed 3"),
                                  std::string("f\xc3\xbcnf \xc2\xa0"), std::string(128, 'x')}) {
    EXPECT_THAT(CheckName(name), IsOk()) << name;
  }
  for (const std::string& name :
       {std::string("a\nb"), std::string("\x7f"), std::string("\xc2\x85"), std::string(1, '\0')}) {
    EXPECT_THAT(CheckName(name), StatusIs(absl::StatusCode::kInvalidArgument,
                                          HasSubstr("allowed: at most 128 bytes of UTF-8")));
  }
  EXPECT_THAT(CheckName(std::string(129, 'x')),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("of 129 bytes")));
}

TEST(SessionOptionsTest, LabelsAreBounded) {
  EXPECT_THAT(CheckLabel("a/b.c-d_1", "any text: 1"), IsOk());
  EXPECT_THAT(CheckLabel(std::string(64, 'k'), std::string(128, 'v')), IsOk());
  for (const std::string& key : {std::string(), std::string("a b"), std::string(65, 'k')}) {
    EXPECT_THAT(CheckLabel(key, ""), StatusIs(absl::StatusCode::kInvalidArgument,
                                              HasSubstr("allowed: 1 to 64 letters, digits")));
  }
  EXPECT_THAT(CheckLabel("seed", "3\n"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("spec.labels['seed'] is")));
  EXPECT_THAT(CheckLabel("seed", std::string(129, 'v')),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("of 129 bytes")));
}

TEST(SessionOptionsTest, TooManyLabelsAreRejected) {
  SessionOptions options;
  for (int i = 0; i < 16; ++i) {
    options.labels[absl::StrCat("key", i)] = "value";
  }
  EXPECT_THAT(CheckSessionOptions(options), IsOk());
  options.labels["another"] = "";
  EXPECT_THAT(CheckSessionOptions(options),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "spec.labels has 17 entries, allowed: at most 16"));
}

}  // namespace
}  // namespace procgen
