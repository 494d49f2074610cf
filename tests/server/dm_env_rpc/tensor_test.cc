#include "server/dm_env_rpc/tensor.h"

#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

dm::Tensor Int32s(const std::vector<int32_t>& elements, const std::vector<int32_t>& shape) {
  dm::Tensor tensor;
  tensor.mutable_int32s()->mutable_array()->Assign(elements.begin(), elements.end());
  tensor.mutable_shape()->Assign(shape.begin(), shape.end());
  return tensor;
}

TEST(TensorTest, ExplicitShapesAreRead) {
  EXPECT_THAT(ReadInt32s("x", Int32s({5}, {}), TensorShape::Scalar()),
              IsOkAndHolds(std::vector<int32_t>{5}));
  EXPECT_THAT(ReadInt32s("x", Int32s({1, 2}, {2}), TensorShape::List(2)),
              IsOkAndHolds(std::vector<int32_t>{1, 2}));
}

TEST(TensorTest, OneElementIsBroadcastAndNegativeDimensionsAreInferred) {
  EXPECT_THAT(ReadInt32s("x", Int32s({7}, {3}), TensorShape::List(3)),
              IsOkAndHolds(std::vector<int32_t>{7, 7, 7}));
  EXPECT_THAT(ReadInt32s("x", Int32s({1, 2}, {-1}), TensorShape::List(2)),
              IsOkAndHolds(std::vector<int32_t>{1, 2}));
  EXPECT_THAT(ReadInt32s("x", Int32s({7}, {-1}), TensorShape::List(3)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("shape [-1] and 1 elements")));
}

TEST(TensorTest, OtherShapesAreNamed) {
  struct Wrong {
    dm::Tensor tensor;
    TensorShape shape;
  };
  for (const Wrong& wrong : {Wrong{Int32s({5}, {1}), TensorShape::Scalar()},
                             Wrong{Int32s({}, {}), TensorShape::Scalar()},
                             Wrong{Int32s({5, 6}, {}), TensorShape::Scalar()},
                             Wrong{Int32s({5, 6}, {2}), TensorShape::List(3)},
                             Wrong{Int32s({5, 6}, {3}), TensorShape::List(3)},
                             Wrong{Int32s({}, {0}), TensorShape::List(3)},
                             Wrong{Int32s({1, 2, 3}, {3, 1}), TensorShape::List(3)},
                             Wrong{Int32s({5}, {-1, -1}), TensorShape::List(1)}}) {
    EXPECT_THAT(ReadInt32s("x", wrong.tensor, wrong.shape),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("x has shape [")))
        << wrong.tensor.DebugString();
  }
  EXPECT_THAT(ReadInt32s("x", Int32s({1}, std::vector<int32_t>(100, 1)), TensorShape::Scalar()),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("1, 1, ...] and 1 elements")));
}

TEST(TensorTest, IntegersOfAnyTypeThatFitInt32AreRead) {
  dm::Tensor tensor;
  tensor.add_shape(2);
  tensor.mutable_int64s()->mutable_array()->Add(INT32_MAX);
  tensor.mutable_int64s()->mutable_array()->Add(INT32_MIN);
  EXPECT_THAT(ReadIntegersAsInt32s("x", tensor, TensorShape::List(2)),
              IsOkAndHolds(std::vector<int32_t>{INT32_MAX, INT32_MIN}));
  tensor.mutable_uint8s()->set_array("\x01\x02");
  EXPECT_THAT(ReadIntegersAsInt32s("x", tensor, TensorShape::List(2)),
              IsOkAndHolds(std::vector<int32_t>{1, 2}));
  tensor.mutable_uint32s()->mutable_array()->Add(7);
  tensor.mutable_uint32s()->mutable_array()->Add(uint32_t{INT32_MAX} + 1);
  EXPECT_THAT(ReadIntegersAsInt32s("x", tensor, TensorShape::List(2)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "x is 2147483648, allowed: -2147483648 to 2147483647"));
  tensor.mutable_floats()->add_array(1);
  EXPECT_THAT(ReadIntegersAsInt32s("x", tensor, TensorShape::List(2)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("an integer type")));
}

TEST(TensorTest, ListsOfAnyLengthAreNotBroadcast) {
  dm::Tensor tensor;
  tensor.mutable_uint8s()->set_array("abc");
  tensor.add_shape(3);
  EXPECT_THAT(ReadBytes("x", tensor), IsOkAndHolds(absl::string_view("abc")));
  tensor.mutable_uint8s()->set_array("a");
  tensor.set_shape(0, std::numeric_limits<int32_t>::max());
  EXPECT_THAT(
      ReadBytes("x", tensor),
      StatusIs(absl::StatusCode::kInvalidArgument,
               "x has shape [2147483647] and 1 elements, allowed: shape [N] with N elements"));
}

TEST(TensorTest, IntegersMayHaveAnyIntegerType) {
  dm::Tensor bytes;
  bytes.mutable_int8s()->set_array("\xfe");
  EXPECT_THAT(ReadInteger("x", bytes, -5, 5), IsOkAndHolds(-2));
  bytes.mutable_uint8s()->set_array("\xfe");
  EXPECT_THAT(ReadInteger("x", bytes, 0, 255), IsOkAndHolds(254));
  EXPECT_THAT(ReadInteger("x", bytes, 0, 9),
              StatusIs(absl::StatusCode::kInvalidArgument, "x is 254, allowed: 0 to 9"));
  dm::Tensor large;
  large.mutable_uint64s()->add_array(std::numeric_limits<uint64_t>::max());
  EXPECT_THAT(ReadInteger("x", large, INT64_MIN, INT64_MAX),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("18446744073709551615")));
  dm::Tensor number;
  number.mutable_doubles()->add_array(1);
  EXPECT_THAT(
      ReadInteger("x", number, 0, 9),
      StatusIs(absl::StatusCode::kInvalidArgument, "x has type DOUBLE, allowed: an integer type"));
  EXPECT_THAT(ReadInteger("x", dm::Tensor(), 0, 9),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("x has type none")));
}

TEST(TensorTest, NumbersAreFinite) {
  dm::Tensor number;
  number.mutable_doubles()->add_array(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(ReadNumber("x", number),
              StatusIs(absl::StatusCode::kInvalidArgument, "x is nan, allowed: a finite number"));
  number.mutable_floats()->add_array(0.5F);
  EXPECT_THAT(ReadNumber("x", number), IsOkAndHolds(0.5));
}

TEST(TensorTest, StringsAreScalarsOrLists) {
  dm::Tensor texts;
  texts.mutable_strings()->add_array("a");
  EXPECT_THAT(ReadTexts("x", texts), IsOkAndHolds(std::vector<std::string>{"a"}));
  texts.mutable_strings()->add_array("b");
  texts.add_shape(2);
  EXPECT_THAT(ReadTexts("x", texts), IsOkAndHolds(std::vector<std::string>{"a", "b"}));
  EXPECT_THAT(ReadText("x", texts), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("[2]")));
}

TEST(TensorTest, LongTextIsCutBetweenCharacters) {
  EXPECT_EQ(Truncated("short"), "short");
  EXPECT_EQ(Truncated(std::string(63, 'a') + "\xc3\xa4 and more"), std::string(63, 'a') + "...");
}

}  // namespace
}  // namespace procgen
