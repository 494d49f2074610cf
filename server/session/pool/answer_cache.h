#ifndef SERVER_SESSION_POOL_ANSWER_CACHE_H_
#define SERVER_SESSION_POOL_ANSWER_CACHE_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/cord.h"

namespace procgen {

// The answer to one request: its responses as sent, in order, opaque here. A Cord shares its bytes,
// so a kept answer and a sent one use the same memory.
using Answer = std::vector<absl::Cord>;

// Answers to the last requests of a pool, for streams that resume.
// Threads: compatible.
class AnswerCache {
 public:
  // Stores the answer to request `number`.
  void Keep(int64_t number, Answer answer);
  // Drops the answers to `number` and all earlier requests.
  void ForgetUpTo(int64_t number);

  // Returns the answer to `number`; null if it is not kept.
  const Answer* Find(int64_t number) const;
  // Returns the lowest number with a kept answer; `none` if there is none.
  int64_t OldestOr(int64_t none) const;
  size_t size() const { return answers_.size(); }
  // The numbers of the kept answers for messages: "5 to 6", or "none".
  std::string Range() const;

 private:
  std::map<int64_t, Answer> answers_;  // by number
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_ANSWER_CACHE_H_
