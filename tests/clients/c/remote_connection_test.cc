// Connections, calls and watches: waits, ends, broken connections and processes.

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/render.pb.h"
#include "tests/clients/c/remote_fixture.h"
#include "tests/service/robustness/fault_proxy.h"
#include "tests/service/robustness/process_resources.h"

namespace procgen {
namespace {

using testing::AnyOf;
using testing::HasSubstr;

class RemoteConnectionTest : public RemoteTest {
 protected:
  static ProcgenCode SendObserve(const CPool& pool, BatchBuffers& buffers) {
    const ProcgenBatch batch = BatchIn(buffers);
    return procgen_send_observe(pool.get(), 0, 4, &batch);
  }

  // Seconds that the body takes.
  template <typename Body>
  static double SecondsOf(const Body& body) {
    const auto begin = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
};

TEST_F(RemoteConnectionTest, AWaitThatIsOverCanBeContinued) {
  const CConnection connection = Connected();
  const CPool pool = MadeOn(connection, COptions("bigfish"));
  const std::vector<BatchBuffers> expected = Steps(Made(COptions("bigfish")).get(), 4, 0, 20);
  for (int32_t t = 0; t < 20; ++t) {
    const std::vector<int32_t> actions = ActionsAt(t, 4);
    const ProcgenStep step = StepOf(actions);
    BatchBuffers buffers(4);
    const ProcgenBatch batch = BatchIn(buffers);
    ASSERT_EQ(procgen_send_step(pool.get(), &step, &batch), PROCGEN_OK);
    ProcgenCode code = procgen_receive(pool.get(), 0);
    while (code == PROCGEN_DEADLINE_EXCEEDED) {
      EXPECT_EQ(procgen_unanswered_count(pool.get()), 1);
      code = procgen_receive(pool.get(), t % 2 == 0 ? 0 : 0.001);
    }
    ASSERT_EQ(code, PROCGEN_OK) << procgen_error_message();
    ASSERT_EQ(buffers, expected[static_cast<size_t>(t)]) << t;
  }
}

TEST_F(RemoteConnectionTest, CallsByPathReturnTheServersMessages) {
  const CConnection connection = Connected();
  std::string response;
  ASSERT_EQ(Call(connection, "/procgen.v1.CatalogService/GetCatalog", "", &response), PROCGEN_OK)
      << procgen_error_message();
  v1::Catalog catalog;
  ASSERT_TRUE(catalog.ParseFromString(response));
  EXPECT_EQ(catalog.games_size(), 16);
  EXPECT_EQ(Call(connection, "/procgen.v1.PoolService/GetPool", NameMessage("pools/no"), &response),
            PROCGEN_NOT_FOUND);
  EXPECT_THAT(procgen_error_message(), HasSubstr("pools/no"));
  EXPECT_EQ(Call(connection, "/procgen.v1.PoolService/NoMethod", "", &response),
            PROCGEN_UNIMPLEMENTED);
  EXPECT_EQ(Call(connection, "GetPool", "", &response), PROCGEN_INVALID_ARGUMENT);
  EXPECT_THAT(procgen_error_message(), HasSubstr("path is GetPool"));
}

v1::WatchPoolResponse NextOf(const CWatch& watch) {
  uint8_t* message = nullptr;
  size_t size = 0;
  v1::WatchPoolResponse response;
  EXPECT_EQ(procgen_watch_next(watch.get(), -1, &message, &size), PROCGEN_OK)
      << procgen_error_message();
  EXPECT_TRUE(response.ParseFromArray(message, static_cast<int>(size)));
  procgen_free(message);
  return response;
}

ProcgenCode EndOf(const CWatch& watch) {
  ProcgenCode code = PROCGEN_OK;
  while (code == PROCGEN_OK) {
    uint8_t* message = nullptr;
    size_t size = 0;
    code = procgen_watch_next(watch.get(), -1, &message, &size);
    if (code == PROCGEN_OK) {
      procgen_free(message);
    }
  }
  return code;
}

CWatch WatchOf(const CConnection& connection, const std::string& pool) {
  v1::WatchPoolRequest request;
  request.set_pool(pool);
  request.add_environments(1);
  request.set_size_px(64);
  request.set_frames_per_second_max(60);
  request.set_with_steps(true);
  const std::string bytes = request.SerializeAsString();
  ProcgenWatch* watch = nullptr;
  EXPECT_EQ(procgen_connection_watch(connection.get(), "/procgen.v1.PoolService/WatchPool",
                                     reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(),
                                     &watch),
            PROCGEN_OK)
      << procgen_error_message();
  return CWatch(watch);
}

TEST_F(RemoteConnectionTest, WatchesReturnTheLatestMessage) {
  const CConnection connection = Connected();
  CPool pool = MadeOn(connection, COptions("bigfish"));
  const CWatch watch = WatchOf(connection, procgen_pool_name(pool.get()));
  EXPECT_EQ(NextOf(watch).request_count(), 0);
  uint8_t* message = nullptr;
  size_t size = 0;
  EXPECT_EQ(procgen_watch_next(watch.get(), 0, &message, &size), PROCGEN_DEADLINE_EXCEEDED);
  EXPECT_EQ(procgen_watch_next(watch.get(), 0.12, &message, &size), PROCGEN_DEADLINE_EXCEEDED);

  const std::vector<int32_t> actions(4, 7);
  const std::vector<float> values = {1, 2, 3, 4, 5, 6, 7, 8};
  const ProcgenAnnotation annotation = {.name = "value", .values = values.data(), .value_count = 2};
  ProcgenStep step = StepOf(actions);
  step.annotations = &annotation;
  step.annotation_count = 1;
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(procgen_step(pool.get(), &step, &batch), PROCGEN_OK) << procgen_error_message();
  }
  v1::WatchPoolResponse response;
  while (response.request_count() < 5) {
    response = NextOf(watch);
  }
  ASSERT_EQ(response.frames_size(), 1);
  ASSERT_EQ(response.frames(0).step().annotations_size(), 1);
  EXPECT_EQ(response.frames(0).step().annotations(0).name(), "value");
  EXPECT_THAT(response.frames(0).step().annotations(0).values(), testing::ElementsAre(3, 4));
  pool = nullptr;
  EXPECT_EQ(EndOf(watch), PROCGEN_ABORTED) << "the pool is deleted";
}

TEST_F(RemoteConnectionTest, StoppingAWatchEndsItsWait) {
  const CConnection connection = Connected();
  const CPool pool = MadeOn(connection, COptions("maze"));
  const CWatch watch = WatchOf(connection, procgen_pool_name(pool.get()));
  std::thread waiter([&] { EXPECT_EQ(EndOf(watch), PROCGEN_CANCELLED); });
  procgen_watch_stop(watch.get());
  waiter.join();
  EXPECT_EQ(EndOf(watch), PROCGEN_CANCELLED);
  EXPECT_EQ(EndOf(WatchOf(connection, "pools/none")), PROCGEN_NOT_FOUND);
}

TEST_F(RemoteConnectionTest, ClosingEndsAllWaits) {
  for (const double timeout_s : {-1.0, 100.0}) {
    FaultProxy proxy({.target = server_->address()});
    const CConnection connection = Connected(ConnectOptionsOf(), proxy.address());
    const CPool pool = MadeOn(connection, COptions("maze"));
    const CWatch watch = WatchOf(connection, procgen_pool_name(pool.get()));
    NextOf(watch);
    proxy.Freeze();
    BatchBuffers buffers(4);
    ASSERT_EQ(SendObserve(pool, buffers), PROCGEN_OK);
    std::atomic<int> waiting = 0;
    std::vector<std::thread> waiters;
    waiters.emplace_back([&] {
      ++waiting;
      EXPECT_EQ(procgen_receive(pool.get(), timeout_s), PROCGEN_CANCELLED);
      EXPECT_STRNE(procgen_error_message(), "");
    });
    waiters.emplace_back([&] {
      ++waiting;
      EXPECT_EQ(EndOf(watch), PROCGEN_CANCELLED);
    });
    waiters.emplace_back([&] {
      ++waiting;
      std::string response;
      EXPECT_EQ(Call(connection, "/procgen.v1.CatalogService/GetLoad", "", &response),
                PROCGEN_CANCELLED);
    });
    while (waiting < 3) {
      std::this_thread::yield();
    }
    procgen_connection_close(connection.get());
    for (std::thread& waiter : waiters) {
      waiter.join();
    }
    std::string response;
    EXPECT_EQ(Call(connection, "/procgen.v1.CatalogService/GetLoad", "", &response),
              PROCGEN_CANCELLED);
    EXPECT_EQ(SendObserve(pool, buffers), PROCGEN_CANCELLED);
    EXPECT_STREQ(procgen_error_message(), "the connection was closed by this client");
  }
}

TEST_F(RemoteConnectionTest, TheCallersCheckCancelsWaits) {
  FaultProxy proxy({.target = server_->address()});
  std::atomic<bool> is_cancelled = false;
  ProcgenConnectOptions options = ConnectOptionsOf();
  options.is_cancelled = [](void* context) {
    return static_cast<int>(*static_cast<std::atomic<bool>*>(context));
  };
  options.context = &is_cancelled;
  const CConnection connection = Connected(options, proxy.address());
  const CPool pool = MadeOn(connection, COptions("maze"));
  const CWatch watch = WatchOf(connection, procgen_pool_name(pool.get()));
  NextOf(watch);
  proxy.Freeze();
  BatchBuffers buffers(4);
  ASSERT_EQ(SendObserve(pool, buffers), PROCGEN_OK);
  is_cancelled = true;
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_CANCELLED);
  EXPECT_EQ(EndOf(watch), PROCGEN_CANCELLED);
  EXPECT_EQ(SendObserve(pool, buffers), PROCGEN_CANCELLED) << "the pool has ended";
}

class RemoteResumeTest : public RemoteConnectionTest,
                         public testing::WithParamInterface<int32_t> {};

TEST_P(RemoteResumeTest, BrokenConnectionsChangeNoResult) {
  FaultProxy proxy({.target = server_->address(),
                    .seed = 3,
                    .bytes_between_faults = GetParam() == PROCGEN_RAW ? 120'000 : 20'000,
                    .silence_max = std::chrono::milliseconds(15)});
  const CConnection connection = Connected(ConnectOptionsOf(), proxy.address());
  const CPool pool = MadeOn(connection, COptions("bigfish"), GetParam());
  const CPool local = Made(COptions("bigfish"));
  proxy.SetFaults(true);
  for (int32_t t = 0; proxy.break_count() < 20; ++t) {
    ASSERT_EQ(Steps(pool.get(), 4, t, 1), Steps(local.get(), 4, t, 1)) << procgen_error_message();
    BatchBuffers buffers(4);
    ASSERT_EQ(SendObserve(pool, buffers), PROCGEN_OK);
    ProcgenCode code = PROCGEN_DEADLINE_EXCEEDED;
    while (code == PROCGEN_DEADLINE_EXCEEDED) {
      code = procgen_receive(pool.get(), 0.001);
    }
    ASSERT_EQ(code, PROCGEN_OK) << procgen_error_message();
  }
  proxy.SetFaults(false);
}

INSTANTIATE_TEST_SUITE_P(Encodings, RemoteResumeTest,
                         testing::Values(PROCGEN_RAW, PROCGEN_DELTA_ZSTD),
                         [](const auto& info) { return "Encoding" + std::to_string(info.param); });

TEST_F(RemoteConnectionTest, WithoutReconnectTimeoutABrokenConnectionEndsThePool) {
  const CConnection connection = Connected(ConnectOptionsOf(0));
  const CPool pool = MadeOn(connection, COptions("maze"));
  server_ = nullptr;
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  const ProcgenCode code = procgen_observe(pool.get(), 0, 4, &batch);
  EXPECT_THAT(code, AnyOf(PROCGEN_UNAVAILABLE, PROCGEN_CANCELLED, PROCGEN_UNKNOWN));
  EXPECT_EQ(procgen_observe(pool.get(), 0, 4, &batch), code);
}

TEST_F(RemoteConnectionTest, DestroyingWithoutAServerIsQuick) {
  FaultProxy proxy({.target = server_->address()});
  CConnection frozen = Connected(ConnectOptionsOf(), proxy.address());
  CConnection connection = Connected();
  CPool frozen_pool = MadeOn(frozen, COptions("maze"));
  CPool pool = MadeOn(connection, COptions("maze"));
  BatchBuffers buffers(4);
  proxy.Freeze();
  ASSERT_EQ(SendObserve(frozen_pool, buffers), PROCGEN_OK);
  server_ = nullptr;
  EXPECT_LT(SecondsOf([&] {
              frozen = nullptr;  // the pool keeps what it needs
              frozen_pool = nullptr;
              pool = nullptr;
              connection = nullptr;
            }),
            8)
      << "of 2 x 10 s in which a server ends a stream";
}

TEST_F(RemoteConnectionTest, DestroyingWithoutAServerClosesItsSockets) {
  const auto lose = [&] {
    FaultProxy proxy({.target = server_->address()});
    const CConnection connection = Connected(ConnectOptionsOf(), proxy.address());
    const CPool pool = MadeOn(connection, COptions("maze"));
    const CWatch watch = WatchOf(connection, procgen_pool_name(pool.get()));
    proxy.Freeze();
    BatchBuffers buffers(4);
    ASSERT_EQ(SendObserve(pool, buffers), PROCGEN_OK);
  };
  lose();
  const int64_t files = ProcessResources::Of(getpid()).file_count;
  for (int i = 0; i < 4; ++i) {
    lose();
  }
  // gRPC closes sockets on a thread of its own. The test's timeout ends this loop.
  while (ProcessResources::Of(getpid()).file_count > files) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

TEST_F(RemoteConnectionTest, PoolsInTheProcessWorkBesideThoseOnAServer) {
  const CConnection connection = Connected();
  const CPool remote = MadeOn(connection, COptions("maze"));
  const CPool local = Made(COptions("maze"));
  EXPECT_EQ(Steps(remote.get(), 4, 0, 3), Steps(local.get(), 4, 0, 3));
}

TEST_F(RemoteConnectionTest, AForkedChildCannotUseConnectionsOrConnect) {
  const CConnection connection = Connected();
  const CPool pool = MadeOn(connection, COptions("maze"));
  const CWatch watch = WatchOf(connection, procgen_pool_name(pool.get()));
  const std::string address = server_->address();
  const pid_t child = fork();
  if (child == 0) {
    BatchBuffers buffers(4);
    const ProcgenBatch batch = BatchIn(buffers);
    std::string response;
    uint8_t* message = nullptr;
    size_t size = 0;
    ProcgenConnection* other = nullptr;
    bool is_refused =
        procgen_observe(pool.get(), 0, 4, &batch) == PROCGEN_FAILED_PRECONDITION &&
        Call(connection, "/procgen.v1.CatalogService/GetLoad", "", &response) ==
            PROCGEN_FAILED_PRECONDITION &&
        procgen_watch_next(watch.get(), -1, &message, &size) == PROCGEN_FAILED_PRECONDITION &&
        procgen_connect(address.c_str(), nullptr, &other) == PROCGEN_FAILED_PRECONDITION;
    is_refused =
        is_refused && std::string(procgen_error_message()).find("spawn") != std::string::npos;
    procgen_watch_stop(watch.get());
    procgen_watch_destroy(watch.get());
    procgen_pool_destroy(pool.get());
    procgen_connection_destroy(connection.get());
    _exit(is_refused && !HasFailure() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(Steps(pool.get(), 4, 0, 3), Steps(Made(COptions("maze")).get(), 4, 0, 3))
      << "the child has left it as it was";
}

}  // namespace
}  // namespace procgen
