// Connections, calls and watches: waits, ends, broken connections and processes.

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen/v1/render.pb.h"
#include "tests/clients/c/remote_fixture.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/service/server_process.h"

namespace procgen {
namespace {

// A server that no longer answers once it is stopped.
struct StoppableServer {
  void Stop() const {
    process.Signal(SIGSTOP);
    waitpid(process.process_id(), nullptr, WUNTRACED);  // Until all threads have stopped.
  }

  ServerProcess process{{"--address=127.0.0.1:0", "--workers=1"}};
  const std::string address = process.Address();
};

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
    StoppableServer server;
    const CConnection connection = Connected(ConnectOptionsOf(), server.address);
    const CPool pool = MadeOn(connection, COptions("maze"));
    const CWatch watch = WatchOf(connection, procgen_pool_name(pool.get()));
    NextOf(watch);
    server.Stop();
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

TEST_F(RemoteConnectionTest, DestroyingWithoutAServerIsQuick) {
  StoppableServer server;
  CConnection frozen = Connected(ConnectOptionsOf(), server.address);
  CConnection connection = Connected();
  CPool frozen_pool = MadeOn(frozen, COptions("maze"));
  CPool pool = MadeOn(connection, COptions("maze"));
  BatchBuffers buffers(4);
  server.Stop();
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
    StoppableServer server;
    const CConnection connection = Connected(ConnectOptionsOf(), server.address);
    const CPool pool = MadeOn(connection, COptions("maze"));
    const CWatch watch = WatchOf(connection, procgen_pool_name(pool.get()));
    server.Stop();
    BatchBuffers buffers(4);
    ASSERT_EQ(SendObserve(pool, buffers), PROCGEN_OK);
  };
  lose();
  const int64_t files = ProcessResources::Of(getpid()).file_count;
  for (int i = 0; i < 2; ++i) {
    lose();
  }
  // gRPC closes sockets on a thread of its own. The test's timeout ends this loop.
  while (ProcessResources::Of(getpid()).file_count > files) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace
}  // namespace procgen
