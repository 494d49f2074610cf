#include "server/fleet/log/request_log.h"

#include "gtest/gtest.h"
#include "tests/server/fleet/journaled_pool.h"

namespace procgen {
namespace {

TEST(RequestLogTest, NumbersCountFromOne) {
  RequestLog log;
  EXPECT_EQ(log.end(), 0);
  EXPECT_EQ(log.Append(SomeStep(41)), 1);
  EXPECT_EQ(log.Append(SomeStep(42)), 2);
  EXPECT_EQ(log.end(), 2);
  EXPECT_EQ(log.Find(1)->request.sequence_number(), 41);
  EXPECT_EQ(log.Find(2)->request.sequence_number(), 42);
}

TEST(RequestLogTest, ContinuesAfterANumber) {
  RequestLog log;
  log.BeginAfter(7);
  EXPECT_EQ(log.end(), 7);
  EXPECT_EQ(log.Append(SomeStep(1)), 8);
  EXPECT_EQ(log.Find(8)->request.sequence_number(), 1);
}

TEST(RequestLogTest, LastEntryIsRemovedAndItsNumberReused) {
  RequestLog log;
  log.Append(SomeStep(1));
  log.Append(SomeStep(2));
  const int64_t bytes = log.BytesAfter(0);
  log.RemoveLast();
  EXPECT_EQ(log.end(), 1);
  EXPECT_LT(log.BytesAfter(0), bytes);
  EXPECT_EQ(log.Append(SomeStep(3)), 2);
  EXPECT_EQ(log.Find(2)->request.sequence_number(), 3);
}

TEST(RequestLogTest, DroppedEntriesKeepTheNumbersOfOthers) {
  RequestLog log;
  for (int64_t i = 1; i <= 5; ++i) {
    log.Append(SomeStep(i));
  }
  const RequestLog::Entry held = log.Find(2);
  log.ForgetUpTo(3);
  EXPECT_EQ(log.Find(4)->request.sequence_number(), 4);
  EXPECT_EQ(log.end(), 5);
  EXPECT_EQ(held->request.sequence_number(), 2) << "a held entry stays valid";
  log.ForgetUpTo(2);
  EXPECT_EQ(log.Find(4)->request.sequence_number(), 4);
  log.ForgetUpTo(9);
  EXPECT_EQ(log.end(), 5);
  EXPECT_EQ(log.Append(SomeStep(6)), 6);
}

TEST(RequestLogTest, BytesCountLaterEntries) {
  RequestLog log;
  EXPECT_EQ(log.BytesAfter(0), 0);
  for (int64_t i = 1; i <= 4; ++i) {
    log.Append(SomeStep(i));
  }
  const int64_t each = log.BytesAfter(3);
  EXPECT_GT(each, 0);
  EXPECT_EQ(log.BytesAfter(0), 4 * each);
  EXPECT_EQ(log.BytesAfter(4), 0);
  log.ForgetUpTo(2);
  EXPECT_EQ(log.BytesAfter(0), 2 * each) << "dropped entries take no memory";
  EXPECT_EQ(log.BytesAfter(3), each);
}

}  // namespace
}  // namespace procgen
