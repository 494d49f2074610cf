// A learner of the C++ client; hostile_test.py describes its output.

#include <array>
#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

#include "absl/strings/str_split.h"
#include "absl/types/span.h"
#include "nlohmann/json.hpp"
#include "procgen_client/client.h"

namespace {

namespace v1 = procgen::v1;

constexpr int32_t kEnvCount = 5;

uint32_t Crc32(uint32_t before, absl::Span<const uint8_t> bytes) {
  static const std::array<uint32_t, 256> table = [] {
    std::array<uint32_t, 256> values = {};
    for (uint32_t i = 0; i < values.size(); ++i) {
      uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) {
        value = (value & 1) != 0 ? (value >> 1) ^ 0xEDB88320U : value >> 1;
      }
      values[i] = value;
    }
    return values;
  }();
  uint32_t crc = ~before;
  for (const uint8_t byte : bytes) {
    crc = table[(crc ^ byte) & 0xFF] ^ (crc >> 8);
  }
  return ~crc;
}

template <typename Element>
absl::Span<const uint8_t> BytesOf(absl::Span<const Element> values) {
  return {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(Element)};
}

uint32_t DigestOf(uint32_t before, const procgen_client::Batch& batch) {
  before = Crc32(before, batch.observations());
  before = Crc32(before, BytesOf(batch.rewards()));
  before = Crc32(before, BytesOf(batch.fingerprints()));
  return Crc32(before, batch.final_observations());
}

// Unary calls.
absl::StatusOr<uint32_t> LookOn(procgen_client::Client* client, const std::string& pool,
                                uint32_t digest) {
  const auto states = client->SaveStates(pool, {2, 0});
  if (!states.ok()) {
    return states.status();
  }
  for (const v1::State& state : *states) {
    const auto size = static_cast<uint32_t>(state.snapshot().size());
    digest = Crc32(digest, BytesOf(absl::MakeConstSpan(&size, 1)));
  }
  const auto frames = client->RenderEnvironments(pool, {1, 3}, 64);
  if (!frames.ok()) {
    return frames.status();
  }
  for (const v1::Frame& frame : frames->frames()) {
    digest = Crc32(digest,
                   {reinterpret_cast<const uint8_t*>(frame.image().data()), frame.image().size()});
  }
  const auto episode = client->GetEpisode(pool, 0, v1::EPISODE_SELECTOR_CURRENT);
  if (!episode.ok()) {
    return episode.status();
  }
  if (const auto pools = client->ListPools(); !pools.ok()) {
    return pools.status();
  }
  if (absl::Status status = client->DeletePool(pool); !status.ok()) {
    return status;
  }
  return digest;
}

absl::StatusOr<uint32_t> Learn(const std::string& address, bool is_encoded) {
  procgen_client::ConnectOptions options;
  options.timeout = absl::Seconds(5);
  options.call_timeout = absl::Seconds(5);
  auto client = procgen_client::Client::Connect(address, options);
  if (!client.ok()) {
    return client.status();
  }
  v1::PoolSpec spec;
  spec.add_games("coinrun");
  spec.set_env_count(kEnvCount);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec.mutable_options()->set_rand_seed(5);
  if (is_encoded) {
    spec.set_encoding(v1::ENCODING_DELTA_ZSTD);
  }
  const auto pool = (*client)->CreatePool(spec);
  if (!pool.ok()) {
    return pool.status();
  }
  auto stream = (*client)->Attach(pool->name(), {.reconnect_timeout = absl::Seconds(1)});
  if (!stream.ok()) {
    return stream.status();
  }
  procgen_client::Batch batch;
  if (absl::Status status = (*stream)->Observe(&batch); !status.ok()) {
    return status;
  }
  uint32_t digest = DigestOf(0, batch);
  for (int32_t step = 0; step < 10; ++step) {
    v1::StepPoolRequest request;
    request.mutable_step()->set_with_final_observations(true);
    for (int32_t i = 0; i < kEnvCount; ++i) {
      request.mutable_step()->add_actions((step * 31 + i * 17) % 16 - 1);
    }
    if (absl::Status status = (*stream)->Call(request, &batch); !status.ok()) {
      return status;
    }
    digest = DigestOf(digest, batch);
  }
  if (absl::Status status = (*stream)->Close(); !status.ok()) {
    return status;
  }
  return LookOn(client->get(), pool->name(), digest);
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): its test sees the end of the program
int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::vector<std::string> words = absl::StrSplit(argv[i], '=');
    std::cout << "begin " << words[0] << std::endl;
    const absl::StatusOr<uint32_t> digest = Learn(words[2], words[1] != "raw");
    nlohmann::json report = {{"mode", words[0]}};
    if (digest.ok()) {
      report["digest"] = *digest;
    } else {
      report["error"] = absl::StatusCodeToString(digest.status().code());
      report["message"] = digest.status().message();
    }
    // Replaces invalid UTF-8, which JSON cannot contain.
    std::cout << report.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) << std::endl;
  }
}
