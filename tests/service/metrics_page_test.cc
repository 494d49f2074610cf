// The program procgen-server with --metrics_address, read over HTTP as Prometheus does.

#include <csignal>
#include <memory>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "httplib.h"
#include "procgen_client/client.h"
#include "tests/service/server_process.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

// The value on the line of `page` that starts with `name`; -1 if there is none.
double ValueOf(const std::string& page, const std::string& name) {
  for (absl::string_view line : absl::StrSplit(page, '\n')) {
    double value = 0;
    if (absl::ConsumePrefix(&line, name + " ") && absl::SimpleAtod(line, &value)) {
      return value;
    }
  }
  return -1;
}

class MetricsPageOfServerTest : public testing::Test {
 protected:
  void SetUp() override {
    address_ = process_.Address();
    ASSERT_NE(address_, "");
    for (absl::string_view field : absl::StrSplit(process_.beginning(), absl::ByAnyChar(" \n"))) {
      if (absl::ConsumePrefix(&field, "metrics=")) {
        metrics_address_ = std::string(field);
      }
    }
    ASSERT_THAT(metrics_address_, testing::StartsWith("127.0.0.1:"));
    auto client = procgen_client::Client::Connect(address_);
    ASSERT_THAT(client, IsOk());
    client_ = *std::move(client);
  }

  // The metrics page; empty if the request fails.
  std::string Page() const {
    const auto answer = httplib::Client("http://" + metrics_address_).Get("/metrics");
    return answer ? answer->body : "";
  }

  ServerProcess process_{{"--address=127.0.0.1:0", "--metrics_address=127.0.0.1:0", "--workers=2"}};
  std::string address_;
  std::string metrics_address_;
  std::unique_ptr<procgen_client::Client> client_;
};

TEST_F(MetricsPageOfServerTest, CountersEqualWhatALearnerDid) {
  v1::PoolSpec spec = MazeSpec(4);
  spec.add_games("heist");
  PoolStream run(ChannelTo(address_));
  ASSERT_THAT(run.Start(spec), IsOk());
  v1::Batch batch;
  ASSERT_THAT(run.Step({4, 4, 4, 4}, &batch), IsOk());
  ASSERT_THAT(run.Step({4, 4, 4, 4}, &batch), IsOk());
  // Environment 1 plays heist.
  ASSERT_THAT(run.Step({4, -1, 4, 4}, &batch), IsOk());
  ASSERT_THAT(run.Call(SliceStepRequest(0, 1, 4), &batch), IsOk());

  const std::string page = Page();
  EXPECT_EQ(ValueOf(page, R"(procgen_steps_total{game="maze",mode="easy"})"), 7);
  EXPECT_EQ(ValueOf(page, R"(procgen_steps_total{game="heist",mode="easy"})"), 6);
  EXPECT_EQ(ValueOf(page, R"(procgen_episode_return_count{game="heist",mode="easy"})"), 1);
  EXPECT_EQ(ValueOf(page, R"(procgen_episode_return_sum{game="heist",mode="easy"})"), 0);
  EXPECT_EQ(ValueOf(page, R"(procgen_episode_length_steps_sum{game="heist",mode="easy"})"), 3);
  EXPECT_EQ(ValueOf(page, R"(procgen_episode_return_count{game="maze",mode="easy"})"), 0);
  EXPECT_EQ(ValueOf(page, "procgen_request_queue_seconds_count"), 4);
  EXPECT_EQ(ValueOf(page, "procgen_request_run_seconds_count"), 4);
  EXPECT_GT(ValueOf(page, "procgen_request_run_seconds_sum"), 0);
  EXPECT_EQ(ValueOf(page, "procgen_pools"), 1);
  EXPECT_EQ(ValueOf(page, "procgen_environments"), 4);
  EXPECT_EQ(ValueOf(page, "procgen_workers"), 2);
  EXPECT_EQ(ValueOf(page, "procgen_draining"), 0);
  const auto load = client_->GetLoad();
  ASSERT_THAT(load, IsOk());
  EXPECT_EQ(ValueOf(page, "procgen_stream_sent_bytes_total"),
            static_cast<double>(load->stream_sent_bytes()));
  EXPECT_EQ(ValueOf(page, "procgen_stream_received_bytes_total"),
            static_cast<double>(load->stream_received_bytes()));
}

TEST_F(MetricsPageOfServerTest, EndsWithTheServer) {
  EXPECT_NE(Page(), "");
  process_.Signal(SIGTERM);
  EXPECT_EQ(process_.Wait(), 0);
  EXPECT_EQ(Page(), "");
}

}  // namespace
}  // namespace procgen
