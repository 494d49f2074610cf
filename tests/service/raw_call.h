#ifndef TESTS_SERVICE_RAW_CALL_H_
#define TESTS_SERVICE_RAW_CALL_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "grpcpp/channel.h"

namespace procgen {

struct RawResult {
  absl::Status status;
  std::vector<std::string> responses;
};

// Calls any method ("/package.Service/Method") with raw bytes as its requests, for requests that no
// generated stub sends. Reads until the call ends or `response_count_max` responses arrived; then
// it cancels the call and returns OK. Sends `token` unless it is empty.
RawResult CallRaw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                  const std::vector<std::string>& requests, const std::string& token = "",
                  size_t response_count_max = SIZE_MAX);

// Opens a TCP connection to "127.0.0.1:PORT" that sends nothing. -1: the server did not accept it.
int ConnectTo(const std::string& address);

}  // namespace procgen

#endif  // TESTS_SERVICE_RAW_CALL_H_
