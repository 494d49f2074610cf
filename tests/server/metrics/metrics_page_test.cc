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
