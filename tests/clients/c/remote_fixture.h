#ifndef TESTS_CLIENTS_C_REMOTE_FIXTURE_H_
#define TESTS_CLIENTS_C_REMOTE_FIXTURE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "clients/c/procgen_remote.h"
#include "gtest/gtest.h"
#include "server/rpc/server.h"
#include "tests/clients/c/c_pool.h"
#include "tests/status_matchers.h"

namespace procgen {

struct DestroyConnection {
  void operator()(ProcgenConnection* connection) const { procgen_connection_destroy(connection); }
};
using CConnection = std::unique_ptr<ProcgenConnection, DestroyConnection>;
struct DestroyWatch {
  void operator()(ProcgenWatch* watch) const { procgen_watch_destroy(watch); }
};
using CWatch = std::unique_ptr<ProcgenWatch, DestroyWatch>;

// Options with defaults.
inline ProcgenConnectOptions ConnectOptionsOf(double reconnect_timeout_s = 60) {
  ProcgenConnectOptions options = {};
  options.struct_size = sizeof(options);
  options.timeout_s = -1;
  options.call_timeout_s = -1;
  options.reconnect_timeout_s = reconnect_timeout_s;
  return options;
}

// A server in this process, and pools on it behind the C ABI.
class RemoteTest : public testing::Test {
 protected:
  void SetUp() override { Start({}); }

  // Starts the server in place of the one before.
  void Start(ServerOptions options) {
    options.address = "127.0.0.1:0";
    options.worker_count = 2;
    auto server = Server::Start(options);
    ASSERT_THAT(server, IsOk());
    server_ = *std::move(server);
  }

  CConnection Connected(const ProcgenConnectOptions& options = ConnectOptionsOf(),
                        std::string address = "") const {
    if (address.empty()) {
      address = server_->address();
    }
    ProcgenConnection* connection = nullptr;
    EXPECT_EQ(procgen_connect(address.c_str(), &options, &connection), PROCGEN_OK)
        << procgen_error_message();
    return CConnection(connection);
  }

  static CPool MadeOn(const CConnection& connection, const ProcgenPoolOptions& options,
                      int32_t encoding = PROCGEN_RAW) {
    ProcgenServerPoolOptions server_options = {};
    server_options.struct_size = sizeof(server_options);
    server_options.encoding = encoding;
    ProcgenPool* pool = nullptr;
    EXPECT_EQ(procgen_connection_create_pool(connection.get(), &options, &server_options, &pool),
              PROCGEN_OK)
        << procgen_error_message();
    return CPool(pool);
  }

  static ProcgenCode Call(const CConnection& connection, const std::string& path,
                          const std::string& request, std::string* response) {
    uint8_t* bytes = nullptr;
    size_t size = 0;
    const ProcgenCode code = procgen_connection_call(
        connection.get(), path.c_str(), reinterpret_cast<const uint8_t*>(request.data()),
        request.size(), &bytes, &size);
    if (code == PROCGEN_OK) {
      response->assign(reinterpret_cast<const char*>(bytes), size);
      procgen_free(bytes);
    }
    return code;
  }

  std::unique_ptr<Server> server_;
};

}  // namespace procgen

#endif  // TESTS_CLIENTS_C_REMOTE_FIXTURE_H_
