#include "server/rpc/services/states_page.h"

#include <numeric>
#include <utility>

#include "absl/hash/hash.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "server/session/backend/environment_list.h"
#include "server/wire/response_limit.h"

namespace procgen {
namespace {

// Upper bound of a response's size without its states (a token and a number), in bytes.
constexpr int64_t kResponseOverheadBytes = 128;
// Upper bound of the size of a state's tag and length, in bytes.
constexpr int64_t kStateOverheadBytes = 8;
constexpr size_t kTokenShownMax = 80;  // characters of an invalid token in an error

}  // namespace

absl::StatusOr<std::unique_ptr<StatesPage>> StatesPage::Begin(const v1::SaveStatesRequest& request,
                                                              const PoolSession& pool,
                                                              const Limits& limits) {
  const absl::StatusOr<int64_t> bytes_max =
      ResponseBytesMax("response_bytes_max", request.response_bytes_max(), limits);
  if (!bytes_max.ok()) {
    return bytes_max.status();
  }
  std::unique_ptr<StatesPage> page(new StatesPage());
  page->environments_.assign(request.environments().begin(), request.environments().end());
  if (page->environments_.empty()) {
    page->environments_.resize(static_cast<size_t>(pool.env_count()));
    std::iota(page->environments_.begin(), page->environments_.end(), 0);
  }
  if (absl::Status status =
          CheckEnvironmentList({.list = "environments", .environments = page->environments_},
                               pool.name(), pool.env_count());
      !status.ok()) {
    return status;
  }
  page->pool_ = pool.name();
  // The creation time distinguishes the pool from an earlier one of the same name.
  page->request_hash_ = absl::HashOf(pool.name(), pool.create_time(), page->environments_);
  page->bytes_max_ = *bytes_max;
  page->bytes_ = kResponseOverheadBytes;
  if (!request.page_token().empty()) {
    if (absl::Status status = page->Continue(request.page_token()); !status.ok()) {
      return status;
    }
  }
  return page;
}

absl::Status StatesPage::Continue(const std::string& token) {
  const std::vector<absl::string_view> parts = absl::StrSplit(token, '-');
  uint64_t request_hash = 0;
  if (parts.size() != 3 || !absl::SimpleAtoi(parts[0], &position_) ||
      !absl::SimpleAtoi(parts[1], &change_number_) ||
      !absl::SimpleHexAtoi(parts[2], &request_hash) || request_hash != request_hash_ ||
      position_ >= environments_.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "page_token is '", token.substr(0, kTokenShownMax),
        "', allowed: the next_page_token of the previous response, with the same pool and "
        "environments"));
  }
  is_first_ = false;
  return absl::OkStatus();
}

absl::Status StatesPage::Open(int64_t change_number) {
  if (!is_first_ && change_number != change_number_) {
    return absl::AbortedError(
        absl::StrCat("environments of pool ", pool_,
                     " were stepped, reset or restored since the previous page;"
                     " start again without page_token"));
  }
  change_number_ = change_number;
  return absl::OkStatus();
}

bool StatesPage::Add(int32_t environment, std::string snapshot, v1::SaveStatesResponse* response) {
  v1::State* state = response->add_states();
  state->set_environment(environment);
  state->set_snapshot(std::move(snapshot));
  const int64_t bytes = static_cast<int64_t>(state->ByteSizeLong()) + kStateOverheadBytes;
  if (bytes > bytes_max_ - bytes_) {
    response->mutable_states()->RemoveLast();
    return false;
  }
  bytes_ += bytes;
  ++position_;
  return true;
}

absl::Status StatesPage::Close(v1::SaveStatesResponse* response) const {
  if (response->states().empty()) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the snapshot of environment ", rest().front(),
                     " does not fit a response, limit response_bytes_max is ", bytes_max_));
  }
  if (!rest().empty()) {
    response->set_next_page_token(
        absl::StrCat(position_, "-", change_number_, "-", absl::Hex(request_hash_)));
  }
  return absl::OkStatus();
}

}  // namespace procgen
