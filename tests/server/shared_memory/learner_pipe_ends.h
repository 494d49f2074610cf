#ifndef TESTS_SERVER_SHARED_MEMORY_LEARNER_PIPE_ENDS_H_
#define TESTS_SERVER_SHARED_MEMORY_LEARNER_PIPE_ENDS_H_

#include <sys/socket.h>

#include <array>
#include <cstring>
#include <optional>

#include "server/shared_memory/file_descriptor.h"

namespace procgen {

// The learner's ends of a PipeConnection, for raw bytes.
struct LearnerPipeEnds {
  FileDescriptor requests;
  FileDescriptor responses;

  // Receives the ends through a socket; nullopt if it was closed without them.
  static std::optional<LearnerPipeEnds> Receive(int socket) {
    std::array<int, 2> ends = {-1, -1};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ends))> control = {};
    char byte = 'x';
    iovec content = {.iov_base = &byte, .iov_len = 1};
    msghdr message = {};
    message.msg_iov = &content;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const bool came = recvmsg(socket, &message, MSG_CMSG_CLOEXEC) == 1 && byte == 0;
    const cmsghdr* const head = CMSG_FIRSTHDR(&message);
    if (!came || head == nullptr || head->cmsg_type != SCM_RIGHTS ||
        head->cmsg_len != CMSG_LEN(sizeof(ends))) {
      return std::nullopt;
    }
    std::memcpy(ends.data(), CMSG_DATA(head), sizeof(ends));
    return LearnerPipeEnds{FileDescriptor(ends[0]), FileDescriptor(ends[1])};
  }
};

}  // namespace procgen

#endif  // TESTS_SERVER_SHARED_MEMORY_LEARNER_PIPE_ENDS_H_
