#ifndef PROCGEN_CLIENT_DIRECT_LINE_H_
#define PROCGEN_CLIENT_DIRECT_LINE_H_

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "procgen/v1/step.pb.h"

namespace procgen_client {

// The learner's side of a direct line (procgen.v1.DirectLine): a unix socket that bears the
// messages of a stream in place of gRPC. Threads: one may send while another receives; HangUp from
// any.
class DirectLine {
 public:
  // Connects; null: that cannot be done from here, and gRPC's stream does as well.
  static std::unique_ptr<DirectLine> Open(const procgen::v1::DirectLine& offer);
  ~DirectLine();
  DirectLine(const DirectLine&) = delete;
  DirectLine& operator=(const DirectLine&) = delete;

  // Waits while the line is full. False: it has ended, and gRPC's stream tells why.
  bool Send(const procgen::v1::StepPoolRequest& request);
  // Waits for the next response. False: as for Send.
  bool Receive(procgen::v1::StepPoolResponse* response);
  // Ends the line for both sides.
  void HangUp();

 private:
  explicit DirectLine(int descriptor) : descriptor_(descriptor) {}
  bool SendAll(const std::string& bytes);
  // Waits until `count` bytes are there from begin_ on.
  bool Fill(size_t count);

  const int descriptor_;
  std::string outgoing_;      // length and message; its memory is kept
  std::vector<char> buffer_;  // received: [begin_, end_)
  size_t begin_ = 0;
  size_t end_ = 0;
  int waits_expected_ = 0;  // times that input is waited for before it is looked for
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_DIRECT_LINE_H_
