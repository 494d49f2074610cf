#ifndef SERVER_SESSION_POOL_KEPT_ANSWERS_H_
#define SERVER_SESSION_POOL_KEPT_ANSWERS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/cord.h"

namespace procgen {

// The answer to one request: its responses as they were sent, in order. What is in them is nobody's
// business here. A Cord shares its bytes, so an answer that is kept and one that is sent are one.
using Answer = std::vector<absl::Cord>;

// Answers to the last requests of a pool, so that they can be asked for again.
// Threads: compatible.
class KeptAnswers {
 public:
  // Keeps the answer to request `number`.
  void Keep(int64_t number, Answer answer);
  // Forgets the answers to `number` and all requests before.
  void ForgetUpTo(int64_t number);

  // The answer to `number`; null: it is not kept.
  const Answer* Find(int64_t number) const;
  // The least number of which the answer is kept; `none` where none is.
  int64_t OldestOr(int64_t none) const;
  size_t size() const { return answers_.size(); }
  // Which are kept, for people: "5 to 6", or "none".
  std::string Range() const;

 private:
  std::map<int64_t, Answer> answers_;  // by number
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_KEPT_ANSWERS_H_
