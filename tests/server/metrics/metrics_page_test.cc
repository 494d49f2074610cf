#include "server/metrics/metrics_page.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "httplib.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(MetricsPageTest, ServesMetricsOverHttp) {
  Metrics metrics("1");
  metrics.OfGame("maze", "hard").AddSteps(64);
  const auto page = MetricsPage::Start("127.0.0.1:0", metrics);
  ASSERT_TRUE(page.ok()) << page.status();
  httplib::Client client("http://" + (*page)->address());
  const auto answer = client.Get("/metrics");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
  EXPECT_THAT(answer->get_header_value("Content-Type"), StartsWith("text/plain"));
  EXPECT_THAT(answer->body, HasSubstr("procgen_steps_total{game=\"maze\",mode=\"hard\"} 64"));
  EXPECT_EQ(client.Get("/other")->status, 404);
}

TEST(MetricsPageTest, AddressInUseIsAnError) {
  Metrics metrics("1");
  const auto page = MetricsPage::Start("127.0.0.1:0", metrics);
  ASSERT_TRUE(page.ok()) << page.status();
  const auto second = MetricsPage::Start((*page)->address(), metrics);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.status().message()), HasSubstr((*page)->address()));
}

}  // namespace
}  // namespace procgen
