#include "clients/c/procgen_remote.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/c/call_guard.h"
#include "clients/c/conversion.h"
#include "procgen_client/client.h"
#include "procgen_client/message_watch.h"
#include "procgen_client/open_calls.h"
#include "procgen_client/remote_pool.h"
#include "procgen_client/servers.h"

namespace procgen_client {

namespace {

// The process that has connected; 0: none. gRPC does not work in its forks.
std::atomic<pid_t> connected_process = 0;

procgen::Status CheckProcess() {
  const pid_t process = getpid();
  pid_t connected = 0;
  if (connected_process.compare_exchange_strong(connected, process) || connected == process) {
    return procgen::OkStatus();
  }
  return procgen::FailedPreconditionError(absl::StrCat(
      "this process, ", process, ", was forked from process ", connected,
      ", which has connections to servers: start it with spawn or forkserver in place of fork"));
}

procgen::Status StatusOf(const absl::Status& status) { return {status.code(), status.message()}; }

procgen::Status ClosedError() {
  return {absl::StatusCode::kCancelled, "the connection was closed by this client"};
}

std::string TextOf(const char* text) { return text == nullptr ? "" : text; }

absl::string_view MessageOf(const uint8_t* message, size_t size) {
  return {reinterpret_cast<const char*>(message), size};
}

void CopyOut(const std::string& message, uint8_t** memory, size_t* size) {
  auto* const copy = static_cast<uint8_t*>(std::malloc(std::max<size_t>(message.size(), 1)));
  if (copy == nullptr) {
    throw std::bad_alloc();
  }
  std::copy(message.begin(), message.end(), copy);
  *memory = copy;
  *size = message.size();
}

ProcgenConnectOptions DefaultConnectOptions() {
  ProcgenConnectOptions options = {};
  options.struct_size = sizeof(options);
  options.timeout_s = -1;
  options.call_timeout_s = -1;
  options.reconnect_timeout_s = 60;
  return options;
}

ConnectOptions ConnectOptionsOf(const ProcgenConnectOptions& options,
                                std::shared_ptr<OpenCalls> calls) {
  ConnectOptions result;
  if (options.timeout_s >= 0) {
    result.timeout = absl::Seconds(options.timeout_s);
  }
  if (options.call_timeout_s >= 0) {
    result.call_timeout = absl::Seconds(options.call_timeout_s);
  }
  result.credentials = Credentials{.ca = TextOf(options.ca),
                                   .certificate = TextOf(options.certificate),
                                   .key = TextOf(options.key),
                                   .token = TextOf(options.token),
                                   .token_in_plain_text = options.token_in_plain_text != 0};
  result.calls = std::move(calls);
  return result;
}

}  // namespace
}  // namespace procgen_client

struct ProcgenConnection {
  std::shared_ptr<procgen_client::OpenCalls> calls;
  std::shared_ptr<procgen_client::Servers> servers;  // first() for calls and watches
  double reconnect_timeout_s = 0;
  procgen_client::ProcessOwner owner = {};
};

struct ProcgenWatch {
  std::shared_ptr<procgen_client::OpenCalls> calls;  // of the connection
  std::unique_ptr<procgen_client::MessageWatch> watch;
  procgen_client::ProcessOwner owner = {};
};

namespace procgen_client {
namespace {

procgen::Status Connect(const char* address, const ProcgenConnectOptions& options,
                        ProcgenConnection** connection) {
  if (!(options.reconnect_timeout_s >= 0)) {
    return procgen::InvalidArgumentError(absl::StrCat(
        "reconnect_timeout_s is ", options.reconnect_timeout_s, ", must be at least 0"));
  }
  if (procgen::Status status = CheckProcess(); !status.ok()) {
    return status;
  }
  auto calls = std::make_shared<OpenCalls>();
  absl::StatusOr<std::shared_ptr<Servers>> servers =
      Servers::Connect(address, ConnectOptionsOf(options, calls));
  if (!servers.ok()) {
    return StatusOf(servers.status());
  }
  *connection = new ProcgenConnection{.calls = std::move(calls),
                                      .servers = *std::move(servers),
                                      .reconnect_timeout_s = options.reconnect_timeout_s};
  return procgen::OkStatus();
}

// As Guard, for functions of an open connection.
template <typename Body>
ProcgenCode GuardConnection(const ProcgenConnection* connection, const Body& body) noexcept {
  return Guard([&]() -> procgen::Status {
    procgen::Status status = CheckNotNull(connection, "connection");
    if (status.ok()) {
      status = connection->owner.Check("connection");
    }
    if (status.ok() && connection->calls->is_closed()) {
      status = ClosedError();
    }
    return status.ok() ? body() : status;
  });
}

procgen::Status CheckRequest(const char* path, const uint8_t* request, size_t request_size) {
  if (path != nullptr && path[0] != '/') {
    return procgen::InvalidArgumentError(
        absl::StrCat("path is ", path, ", must be one as /procgen.v1.PoolService/GetPool"));
  }
  return FirstError(
      {CheckNotNull(path, "path"),
       CheckArray(request, "request", static_cast<int64_t>(request_size), "request_size")});
}

// Splits labels, "key=value". The server validates keys and values.
procgen::StatusOr<std::map<std::string, std::string>> LabelsOf(
    const ProcgenServerPoolOptions& options) {
  if (procgen::Status status =
          CheckArray(options.labels, "labels", options.label_count, "label_count");
      !status.ok()) {
    return status;
  }
  std::map<std::string, std::string> labels;
  for (int32_t i = 0; i < options.label_count; ++i) {
    const std::string label = TextOf(options.labels[i]);
    const size_t end = label.find('=');
    if (end == std::string::npos) {
      return procgen::InvalidArgumentError(
          absl::StrCat("labels[", i, "] is '", label, "', must be 'key=value'"));
    }
    labels[label.substr(0, end)] = label.substr(end + 1);
  }
  return labels;
}

procgen::Status CreatePoolOn(const ProcgenConnection& connection, const ProcgenPoolOptions& given,
                             const ProcgenServerPoolOptions& server_options, ProcgenPool** pool) {
  const ProcgenPoolOptions options = Complete(given, DefaultPoolOptions());
  if (!TextOf(options.art).empty()) {
    return procgen::InvalidArgumentError(
        absl::StrCat("art is ", options.art, ", must be null: a server draws with its own art"));
  }
  if (server_options.encoding != PROCGEN_RAW && server_options.encoding != PROCGEN_DELTA_ZSTD) {
    return procgen::InvalidArgumentError(absl::StrCat("encoding is ", server_options.encoding,
                                                      ", must be one of ", PROCGEN_RAW, ", ",
                                                      PROCGEN_DELTA_ZSTD));
  }
  const auto pool_options = PoolOptionsOf(options);
  if (!pool_options.ok()) {
    return pool_options.status();
  }
  const auto labels = LabelsOf(server_options);
  if (!labels.ok()) {
    return labels.status();
  }
  RemotePoolOptions remote;
  remote.display_name = TextOf(server_options.display_name);
  remote.labels = *labels;
  remote.pool_id = TextOf(server_options.pool_id);
  remote.encoding = server_options.encoding == PROCGEN_RAW ? procgen::v1::ENCODING_RAW
                                                           : procgen::v1::ENCODING_DELTA_ZSTD;
  remote.recovery.reconnect_timeout = absl::Seconds(connection.reconnect_timeout_s);
  auto created = CreatePool(connection.servers, *pool_options, remote);
  if (!created.ok()) {
    return created.status();
  }
  *pool = new ProcgenPool{.pool = *std::move(created)};
  return procgen::OkStatus();
}

}  // namespace
}  // namespace procgen_client

ProcgenCode procgen_connect(const char* address, const ProcgenConnectOptions* options,
                            ProcgenConnection** connection) {
  return procgen_client::Guard([&]() -> procgen::Status {
    const ProcgenConnectOptions defaults = procgen_client::DefaultConnectOptions();
    const ProcgenConnectOptions* const given = options == nullptr ? &defaults : options;
    if (procgen::Status status =
            procgen_client::FirstError({procgen_client::CheckNotNull(address, "address"),
                                        procgen_client::CheckStruct(given, "options"),
                                        procgen_client::CheckNotNull(connection, "connection")});
        !status.ok()) {
      return status;
    }
    return procgen_client::Connect(address, procgen_client::Complete(*given, defaults), connection);
  });
}

void procgen_connection_close(ProcgenConnection* connection) {
  if (connection != nullptr && connection->owner.is_this_process()) {
    connection->calls->Close();
  }
}

void procgen_connection_destroy(ProcgenConnection* connection) {
  if (connection != nullptr && connection->owner.is_this_process()) {
    procgen_connection_close(connection);
    delete connection;
  }
}

ProcgenCode procgen_connection_call(ProcgenConnection* connection, const char* path,
                                    const uint8_t* request, size_t request_size, uint8_t** response,
                                    size_t* response_size) {
  return procgen_client::GuardConnection(connection, [&]() -> procgen::Status {
    if (procgen::Status status = procgen_client::FirstError(
            {procgen_client::CheckRequest(path, request, request_size),
             procgen_client::CheckNotNull(response, "response"),
             procgen_client::CheckNotNull(response_size, "response_size")});
        !status.ok()) {
      return status;
    }
    const auto answer =
        connection->servers->first()->Call(path, procgen_client::MessageOf(request, request_size));
    if (!answer.ok()) {
      return procgen_client::StatusOf(answer.status());
    }
    procgen_client::CopyOut(*answer, response, response_size);
    return procgen::OkStatus();
  });
}

void procgen_free(void* memory) { std::free(memory); }

ProcgenCode procgen_connection_watch(ProcgenConnection* connection, const char* path,
                                     const uint8_t* request, size_t request_size,
                                     ProcgenWatch** watch) {
  return procgen_client::GuardConnection(connection, [&]() -> procgen::Status {
    if (procgen::Status status =
            procgen_client::FirstError({procgen_client::CheckRequest(path, request, request_size),
                                        procgen_client::CheckNotNull(watch, "watch")});
        !status.ok()) {
      return status;
    }
    *watch = new ProcgenWatch{.calls = connection->calls,
                              .watch = connection->servers->first()->WatchMessages(
                                  path, procgen_client::MessageOf(request, request_size))};
    return procgen::OkStatus();
  });
}

ProcgenCode procgen_watch_next(ProcgenWatch* watch, double timeout_s, uint8_t** message,
                               size_t* size) {
  return procgen_client::Guard([&]() -> procgen::Status {
    if (procgen::Status status =
            procgen_client::FirstError({procgen_client::CheckNotNull(watch, "watch"),
                                        procgen_client::CheckNotNull(message, "message"),
                                        procgen_client::CheckNotNull(size, "size")});
        !status.ok()) {
      return status;
    }
    if (procgen::Status status = watch->owner.Check("watch"); !status.ok()) {
      return status;
    }
    const auto next = watch->watch->Next(std::chrono::duration<double>(timeout_s));
    if (watch->calls->is_closed()) {
      return procgen_client::ClosedError();
    }
    if (!next.ok()) {
      return procgen_client::StatusOf(next.status());
    }
    if (!next->has_value()) {
      return procgen::DeadlineExceededError("no message has arrived since the last");
    }
    procgen_client::CopyOut(**next, message, size);
    return procgen::OkStatus();
  });
}

void procgen_watch_stop(ProcgenWatch* watch) {
  if (watch != nullptr && watch->owner.is_this_process()) {
    watch->watch->Stop();
  }
}

void procgen_watch_destroy(ProcgenWatch* watch) {
  if (watch != nullptr && watch->owner.is_this_process()) {
    delete watch;
  }
}

ProcgenCode procgen_connection_create_pool(ProcgenConnection* connection,
                                           const ProcgenPoolOptions* options,
                                           const ProcgenServerPoolOptions* server_options,
                                           ProcgenPool** pool) {
  return procgen_client::GuardConnection(connection, [&]() -> procgen::Status {
    ProcgenServerPoolOptions defaults = {};
    defaults.struct_size = sizeof(defaults);
    const ProcgenServerPoolOptions* const given =
        server_options == nullptr ? &defaults : server_options;
    if (procgen::Status status =
            procgen_client::FirstError({procgen_client::CheckStruct(options, "options"),
                                        procgen_client::CheckStruct(given, "server_options"),
                                        procgen_client::CheckNotNull(pool, "pool")});
        !status.ok()) {
      return status;
    }
    return procgen_client::CreatePoolOn(*connection, *options,
                                        procgen_client::Complete(*given, defaults), pool);
  });
}

const char* procgen_pool_name(const ProcgenPool* pool) {
  return pool == nullptr ? "" : pool->pool->name().c_str();
}
