#ifndef PROCGEN_CLIENT_RUN_GRPC_RUN_STREAM_H_
#define PROCGEN_CLIENT_RUN_GRPC_RUN_STREAM_H_

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/completion_queue.h"
#include "grpcpp/generic/generic_stub.h"
#include "procgen_client/run/run_stream.h"

namespace procgen_client {

// The events of calls that one thread waits for, in turn. It does the work of all their
// connections, so that responses of several servers arrive at once. Threads: compatible.
class EventQueue {
 public:
  EventQueue() = default;
  ~EventQueue();
  EventQueue(const EventQueue&) = delete;
  EventQueue& operator=(const EventQueue&) = delete;

 private:
  friend class GrpcRunStream;

  grpc::CompletionQueue queue_;
};

// A call of RunPool over gRPC. The thread that waits in Next does the work of the connection.
class GrpcRunStream final : public RunStream {
 public:
  // Begins the call. `token`: empty: none. `events`: shared by calls of one thread.
  GrpcRunStream(const std::shared_ptr<grpc::Channel>& channel, const std::string& token,
                std::shared_ptr<EventQueue> events);
  // Cancels the call and waits for its end.
  ~GrpcRunStream() override;
  GrpcRunStream(const GrpcRunStream&) = delete;
  GrpcRunStream& operator=(const GrpcRunStream&) = delete;

  void Write(const procgen::v1::RunPoolRequest& request) override;
  void HalfClose() override;
  Event Next(absl::Duration timeout) override;
  grpc::ByteBuffer& response() override { return response_; }
  const absl::Status& status() const override { return status_; }
  bool is_lost() const override { return is_lost_; }
  void Cancel() override { context_.TryCancel(); }

 private:
  enum Operation { kStart, kWrite, kHalfClose, kRead, kFinish };
  static constexpr int kOperationCount = 5;
  // What gRPC returns for an operation.
  struct Tag {
    GrpcRunStream* stream = nullptr;
    Operation operation = kStart;
  };
  // An operation that is over.
  struct Done {
    Operation operation = kStart;
    bool is_ok = false;
  };

  void* TagOf(Operation operation) { return &tags_[operation]; }
  // Waits for an event of any call of the queue. False: the time is over.
  bool Poll(gpr_timespec deadline);

  void Begin(Operation operation);
  // Handles an event of the call. `is_ok`: as gRPC says.
  Event On(Operation operation, bool is_ok);

  const std::shared_ptr<EventQueue> events_;
  std::array<Tag, kOperationCount> tags_;
  std::deque<Done> done_;  // not handled yet
  grpc::ClientContext context_;
  grpc::GenericStub stub_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  std::optional<grpc::ByteBuffer> waiting_;  // written before the call was established
  grpc::ByteBuffer read_;                    // of the read in progress
  grpc::ByteBuffer response_;
  bool is_established_ = false;
  bool is_failed_ = false;  // an operation failed; the status follows
  bool is_over_ = false;
  int operation_count_ = 0;  // in progress
  grpc::Status grpc_status_;
  absl::Status status_;
  bool is_lost_ = false;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_RUN_GRPC_RUN_STREAM_H_
