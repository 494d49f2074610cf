#include "server/config.h"

#include <cstdint>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

constexpr int64_t kLeaseSecondsMax = int64_t{366} * 24 * 3600;
constexpr int64_t kKeepaliveMsMax = 24 * 3600 * 1000;

struct Range {
  absl::string_view flag;
  int64_t value;
  int64_t min;
  int64_t max;
};

absl::Status CheckAddress(const std::string& address) {
  const size_t colon = address.rfind(':');
  int port = -1;
  const bool is_unix = absl::StartsWith(address, "unix:") && address.size() > 5;
  const bool is_tcp = !absl::StartsWith(address, "unix:") && colon != std::string::npos &&
                      colon > 0 && absl::SimpleAtoi(address.substr(colon + 1), &port) &&
                      port >= 0 && port <= UINT16_MAX;
  if (!is_unix && !is_tcp) {
    return absl::InvalidArgumentError(
        absl::StrCat("--address is '", address,
                     "', allowed: 'HOST:PORT' with a port of 0 to 65535, or 'unix:PATH'"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckConfig(const Config& config) {
  if (absl::Status status = CheckAddress(config.server.address); !status.ok()) {
    return status;
  }
  const Limits& limits = config.server.limits;
  for (const Range& range :
       {Range{"workers", config.server.worker_count, 1, 1024},
        Range{"pool_count_max", limits.pool_count_max, 1, 1 << 20},
        Range{"pool_environment_count_max", limits.pool_environment_count_max, 1, 1 << 20},
        Range{"environment_count_max", limits.environment_count_max, 1, 1 << 20},
        Range{"observation_bytes_max", limits.observation_bytes_max, kMessageBytesMin,
              int64_t{1} << 40},
        Range{"request_bytes_max", limits.request_bytes_max, kMessageBytesMin, INT32_MAX},
        Range{"response_bytes_max", limits.response_bytes_max, kMessageBytesMin, INT32_MAX},
        Range{"requests_in_flight_max", limits.requests_in_flight_max, 1, 1024},
        Range{"kept_answer_bytes_max", limits.kept_answer_bytes_max, 0, int64_t{1} << 40},
        Range{"lease_duration_max in seconds", absl::ToInt64Seconds(limits.lease_duration_max), 1,
              kLeaseSecondsMax},
        Range{"keepalive_time in milliseconds",
              absl::ToInt64Milliseconds(config.server.keepalive_time), 100, kKeepaliveMsMax},
        Range{"keepalive_timeout in milliseconds",
              absl::ToInt64Milliseconds(config.server.keepalive_timeout), 100, kKeepaliveMsMax},
        Range{"drain_deadline in seconds", absl::ToInt64Seconds(config.drain_deadline), 0, 3600}}) {
    if (range.value < range.min || range.value > range.max) {
      return absl::InvalidArgumentError(absl::StrCat("--", range.flag, " is ", range.value,
                                                     ", allowed: ", range.min, " to ", range.max));
    }
  }
  if (limits.pool_environment_count_max > limits.environment_count_max) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--pool_environment_count_max is ", limits.pool_environment_count_max,
        ", allowed: at most --environment_count_max, which is ", limits.environment_count_max));
  }
  return absl::OkStatus();
}

}  // namespace procgen
