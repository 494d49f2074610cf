#include "server/web/http/site.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen::web {
namespace {

class SiteTest : public testing::Test {
 protected:
  static HttpRequestInfo RequestTo(const std::string& target,
                                   const std::string& host = "127.0.0.1:8080") {
    HttpRequestInfo request;
    request.method = "GET";
    request.target = target;
    request.host = host;
    request.local_host = "127.0.0.1";
    return request;
  }
  Reply Socket(const std::string& host, const std::string& origin, bool is_secure = false) const {
    HttpRequestInfo request = RequestTo("/bridge", host);
    request.origin = origin;
    request.is_secure = is_secure;
    return site_.ReplyToSocket(request);
  }

  const Site site_{{"lab.example"},
                   {{"index.html", "<live>"},
                    {"play.html", "<play>"},
                    {"a/b.html", "<inner>"},
                    {"a/b.js", "script"},
                    {"a/b.js.gz", "smaller"},
                    {"style/page.css", "style"}}};
};

TEST_F(SiteTest, PagesHaveTheirPathsAndOtherFilesAreUnderAssets) {
  EXPECT_EQ(site_.ReplyToPage(RequestTo("/")).contents, "<live>");
  EXPECT_EQ(site_.ReplyToPage(RequestTo("/play?game=maze&level_seed=1")).contents, "<play>");
  EXPECT_EQ(site_.ReplyToPage(RequestTo("/assets/a/b.js")).contents, "script");
  EXPECT_EQ(site_.ReplyToPage(RequestTo("/assets/a/b.js")).content_type,
            "text/javascript; charset=utf-8");
  EXPECT_EQ(site_.ReplyToPage(RequestTo("/assets/a/b.html")).contents, "<inner>");
  for (const char* missing : {"/index.html", "/play.html", "/a/b.js", "/assets/play.html", "",
                              "play", "/play/", "/assets/../play"}) {
    EXPECT_EQ(site_.ReplyToPage(RequestTo(missing)).status, 404) << missing;
  }
}

TEST_F(SiteTest, EtagIdentifiesTheContents) {
  HttpRequestInfo request = RequestTo("/");
  const std::string etag = site_.ReplyToPage(request).etag;
  EXPECT_NE(etag, site_.ReplyToPage(RequestTo("/play")).etag);
  request.if_none_match = etag;
  EXPECT_EQ(site_.ReplyToPage(request).status, 304);
  EXPECT_EQ(site_.ReplyToPage(request).contents, "");
}

TEST_F(SiteTest, BrowsersThatAcceptItGetTheCompressedForm) {
  HttpRequestInfo request = RequestTo("/assets/a/b.js");
  const Reply plain = site_.ReplyToPage(request);
  EXPECT_FALSE(plain.is_gzip);
  request.accepts_gzip = true;
  const Reply compressed = site_.ReplyToPage(request);
  EXPECT_TRUE(compressed.is_gzip);
  EXPECT_EQ(compressed.contents, "smaller");
  EXPECT_EQ(compressed.content_type, plain.content_type);
  EXPECT_NE(compressed.etag, plain.etag);
  request.if_none_match = compressed.etag;
  EXPECT_EQ(site_.ReplyToPage(request).status, 304);
  request.accepts_gzip = false;
  EXPECT_EQ(site_.ReplyToPage(request).status, 200);
  request = RequestTo("/play");
  request.accepts_gzip = true;
  EXPECT_FALSE(site_.ReplyToPage(request).is_gzip);
  EXPECT_EQ(site_.ReplyToPage(RequestTo("/assets/a/b.js.gz")).status, 404);
}

TEST_F(SiteTest, AllowedHostsMatchAnyPort) {
  for (const char* host :
       {"localhost", "LocalHost:1", "127.0.0.1", "lab.example", "LAB.example:443"}) {
    EXPECT_EQ(site_.ReplyToPage(RequestTo("/", host)).status, 200) << host;
  }
  for (const char* host :
       {"", "evil.example", "lab.example.evil", "127.0.0.2", "[::1]", "[", "localhost.evil:80",
        ":80", "127.0.0.1evil", "127.0.0.1:evil.example", "localhost:80:80", "localhost:65536",
        "localhost:-1", "localhost: 80", "[127.0.0.1]evil", "[localhost]80"}) {
    EXPECT_EQ(site_.ReplyToPage(RequestTo("/", host)).status, 421) << host;
  }
  HttpRequestInfo request = RequestTo("/", "[::1]:80");
  request.local_host = "::1";
  EXPECT_EQ(site_.ReplyToPage(request).status, 200);
  request.host = "[::1]evil:80";
  EXPECT_EQ(site_.ReplyToPage(request).status, 421);
}

TEST_F(SiteTest, OnlySameOriginPagesGetASocket) {
  EXPECT_EQ(Socket("127.0.0.1:8080", "http://127.0.0.1:8080").status, 101);
  EXPECT_EQ(Socket("Lab.example", "http://lab.EXAMPLE").status, 101);
  EXPECT_EQ(Socket("lab.example", "https://lab.example", /*is_secure=*/true).status, 101);
  EXPECT_EQ(Socket("lab.example", "https://lab.example").status, 403);
  EXPECT_EQ(Socket("lab.example", "http://lab.example", /*is_secure=*/true).status, 403);
  EXPECT_EQ(Socket("127.0.0.1:8080", "http://localhost:8080").status, 403);
  EXPECT_EQ(Socket("127.0.0.1:8080", "").status, 403);
  EXPECT_EQ(Socket("127.0.0.1:8080", "null").status, 403);
  EXPECT_EQ(Socket("evil.example", "http://evil.example").status, 421);
}

TEST_F(SiteTest, InvalidHostIsNotEchoedInAHeader) {
  HttpRequestInfo request = RequestTo("/", "a;script-src evil.example");
  for (const auto& [name, value] : Site::SafetyHeaders(request)) {
    EXPECT_EQ(value.find("evil"), std::string::npos) << name;
  }
  const std::string text = site_.ReplyToPage(RequestTo("/", "<b>\x01")).text;
  EXPECT_THAT(text, testing::HasSubstr("\\001"));
}

}  // namespace
}  // namespace procgen::web
