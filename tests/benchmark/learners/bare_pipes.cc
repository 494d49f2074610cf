#include "tests/benchmark/learners/bare_pipes.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>

#include "absl/types/span.h"

namespace procgen {
namespace {

bool MakePipe(FileDescriptor* read_end, FileDescriptor* write_end) {
  std::array<int, 2> ends = {-1, -1};
  const bool made = pipe2(ends.data(), O_CLOEXEC) == 0;
  *read_end = FileDescriptor(ends[0]);
  *write_end = FileDescriptor(ends[1]);
  return made;
}

// Both return whether the whole span was written or read.
bool Write(const FileDescriptor& end, absl::Span<const char> message) {
  return write(end.number(), message.data(), message.size()) ==
         static_cast<ssize_t>(message.size());
}

bool Read(const FileDescriptor& end, absl::Span<char> message) {
  while (!message.empty()) {
    const ssize_t count = read(end.number(), message.data(), message.size());
    if (count <= 0) {
      return false;
    }
    message.remove_prefix(static_cast<size_t>(count));
  }
  return true;
}

}  // namespace

absl::StatusOr<std::unique_ptr<BarePipes>> BarePipes::Start(size_t request_bytes,
                                                            size_t answer_bytes) {
  std::unique_ptr<BarePipes> pipes(new BarePipes(request_bytes, answer_bytes));
  if (!MakePipe(&pipes->requests_, &pipes->learners_requests_) ||
      !MakePipe(&pipes->learners_answers_, &pipes->answers_)) {
    return absl::ResourceExhaustedError("no file descriptors are left for pipes");
  }
  pipes->learner_ = std::thread([learner = pipes.get()] { learner->Ask(); });
  return pipes;
}

BarePipes::BarePipes(size_t request_bytes, size_t answer_bytes)
    : request_(request_bytes), answer_(answer_bytes) {}

BarePipes::~BarePipes() {
  answers_ = FileDescriptor();
  if (learner_.joinable()) {
    learner_.join();
  }
}

absl::Status BarePipes::Exchange() {
  if (!Write(answers_, answer_) || !Read(requests_, absl::MakeSpan(request_))) {
    return absl::UnavailableError("the pipes have ended");
  }
  return absl::OkStatus();
}

void BarePipes::Ask() {
  const std::vector<char> request(request_.size());
  std::vector<char> answer(answer_.size());
  while (Write(learners_requests_, request) && Read(learners_answers_, absl::MakeSpan(answer))) {
  }
}

}  // namespace procgen
