#include "server/web/json/message.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen::web {
namespace {

using ::testing::HasSubstr;

std::string Binary(const std::string& header, const std::string& rest) {
  std::string bytes(4, '\0');
  bytes[0] = static_cast<char>(header.size());
  bytes[1] = static_cast<char>(header.size() >> 8);
  return absl::StrCat(bytes, header, rest);
}

std::string ErrorOf(const std::string& bytes, bool is_binary) {
  return std::string(ParseRequest(bytes, is_binary).status().message());
}

TEST(ParseRequestTest, TextHasAMethodAndMembers) {
  const auto request = ParseRequest(R"({"id": 7, "method": "play.step", "action": 3})", false);
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->id, 7);
  EXPECT_EQ(request->method, "play.step");
  EXPECT_EQ(request->members, Json({{"action", 3}}));
  EXPECT_TRUE(request->parts.empty());
}

TEST(ParseRequestTest, BinaryHasPartsInTheirOrder) {
  const auto request = ParseRequest(
      Binary(R"({"id":1,"method":"m","parts":[{"name":"a","format":"trace","bytes":3},)"
             R"({"name":"b","format":"x","bytes":0},{"name":"c","format":"x","bytes":2}]})",
             "12345"),
      true);
  ASSERT_TRUE(request.ok()) << request.status();
  ASSERT_EQ(request->parts.size(), 3U);
  EXPECT_EQ(request->parts[0].bytes, "123");
  EXPECT_EQ(request->parts[1].bytes, "");
  EXPECT_EQ(request->parts[2].bytes, "45");
  EXPECT_EQ(request->members, Json::object());
}

TEST(ParseRequestTest, InvalidMessagesAreExplained) {
  EXPECT_EQ(ErrorOf("[]", false), "the message is not a JSON object");
  EXPECT_EQ(ErrorOf("\xff", false), "the message is not a JSON object");
  EXPECT_THAT(ErrorOf(R"({"id": -1, "method": ""})", false), HasSubstr("id is not an integer"));
  EXPECT_THAT(ErrorOf(R"({"id": 1e3, "method": ""})", false), HasSubstr("id is not an integer"));
  EXPECT_THAT(ErrorOf(R"({"id": 1})", false), HasSubstr("method is not a text"));
  EXPECT_THAT(ErrorOf(std::string(kHeaderBytesMax + 1, ' '), false), HasSubstr("65537 bytes"));
  EXPECT_THAT(ErrorOf("abc", true), HasSubstr("shorter than the header"));
  EXPECT_THAT(ErrorOf("\x05{}", true), HasSubstr("shorter than the header"));
  EXPECT_THAT(ErrorOf(Binary(R"({"id":1,"method":"m"})", "x"), true), HasSubstr("1 bytes more"));
  EXPECT_THAT(ErrorOf(Binary(R"({"id":1,"method":"m","parts":7})", ""), true),
              HasSubstr("parts is not a list"));
}

TEST(ParseRequestTest, DeepNestingIsHarmless) {
  const std::string depth(30000, '[');
  EXPECT_THAT(ErrorOf(depth, false), HasSubstr("not a JSON object"));
  const std::string object =
      absl::StrCat(R"({"id":1,"method":"m","x":)", depth, std::string(30000, ']'), "}");
  const auto request = ParseRequest(object, false);
  ASSERT_TRUE(request.ok());
  RequestParams params(request->members);
  EXPECT_EQ(params.Integer("x", 3, 5), 3);
  EXPECT_EQ(params.CheckAll().message(), "x is array, allowed: integers from 3 to 5");
}

TEST(WireMessageTest, AnswersAreTextUnlessTheyHaveParts) {
  const WireMessage text = EncodeAnswer(7, Answer{{{"a", 1}}, {}});
  EXPECT_FALSE(text.is_binary);
  EXPECT_EQ(Json::parse(text.bytes), Json({{"id", 7}, {"result", {{"a", 1}}}}));

  const WireMessage binary =
      EncodeAnswer(7, Answer{{{"a", 1}}, {{"p", "rgb", "xyz", {{"width", 1}}}}});
  EXPECT_TRUE(binary.is_binary);
  const size_t length = static_cast<uint8_t>(binary.bytes[0]);
  const Json header = Json::parse(binary.bytes.substr(4, length));
  EXPECT_EQ(header["parts"], Json::parse(R"([{"name":"p","format":"rgb","bytes":3,"width":1}])"));
  EXPECT_EQ(binary.bytes.substr(4 + length), "xyz");
}

TEST(WireMessageTest, ErrorsHaveCodesAndValidUtf8Text) {
  const WireMessage message = EncodeAnswer(7, absl::NotFoundError("no pool \xc3"));
  EXPECT_EQ(Json::parse(message.bytes)["error"]["code"], "NOT_FOUND");
  EXPECT_EQ(Json::parse(message.bytes)["error"]["message"], "no pool \xef\xbf\xbd");
}

TEST(RequestParamsTest, FirstInvalidParameterIsReported) {
  const Json members = {{"a", 1}, {"b", "x"}, {"c", 3}};
  RequestParams params(members);
  EXPECT_EQ(params.Integer("a", 0, 9), 1);
  EXPECT_EQ(params.Integer("b", 0, 9), 0);
  EXPECT_EQ(params.Text("c"), "");
  EXPECT_EQ(params.CheckAll().message(), "b is 'x', allowed: integers from 0 to 9");
}

TEST(RequestParamsTest, BooleansAreOptional) {
  const Json members = {{"a", true}, {"b", 1}};
  RequestParams params(members);
  EXPECT_TRUE(params.BooleanOr("a", false));
  EXPECT_TRUE(params.BooleanOr("missing", true));
  EXPECT_FALSE(params.BooleanOr("b", false));
  EXPECT_EQ(params.CheckAll().message(), "b is 1, allowed: true, false");
}

TEST(RequestParamsTest, UnknownParametersAreRejected) {
  const Json members = {{"a", 1}, {"b", 2}};
  RequestParams params(members);
  params.Integer("a", 0, 9);
  EXPECT_EQ(params.CheckAll().message(), "'b' is no member of this request; its members: a");
}

TEST(RequestParamsTest, NumbersAreRangeCheckedBeforeConversion) {
  const Json members = {{"a", UINT64_MAX}, {"b", INT64_MIN}, {"c", 1e300}, {"d", {1, UINT64_MAX}}};
  for (const char* name : {"a", "b", "c"}) {
    RequestParams params(members);
    EXPECT_EQ(params.Integer(name, -5, 5), -5);
    EXPECT_THAT(std::string(params.CheckAll().message()), HasSubstr(" is "));
  }
  RequestParams params(members);
  params.Integers("d", 4, 100);
  EXPECT_EQ(params.CheckAll().message(), "d is not a list of 1 to 4 integers from 0 to 100");
}

}  // namespace
}  // namespace procgen::web
