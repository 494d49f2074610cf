#include "server/session/pool/answer_cache.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {

void AnswerCache::Keep(int64_t number, Answer answer) {
  answers_.insert_or_assign(number, std::move(answer));
}

void AnswerCache::ForgetUpTo(int64_t number) {
  answers_.erase(answers_.begin(), answers_.upper_bound(number));
}

const Answer* AnswerCache::Find(int64_t number) const {
  const auto found = answers_.find(number);
  return found == answers_.end() ? nullptr : &found->second;
}

int64_t AnswerCache::OldestOr(int64_t none) const {
  return answers_.empty() ? none : answers_.begin()->first;
}

std::string AnswerCache::Range() const {
  if (answers_.empty()) {
    return "none";
  }
  return absl::StrCat(answers_.begin()->first, " to ", answers_.rbegin()->first);
}

}  // namespace procgen
