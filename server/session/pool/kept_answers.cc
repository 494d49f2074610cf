#include "server/session/pool/kept_answers.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {

void KeptAnswers::Keep(int64_t number, Answer answer) {
  answers_.insert_or_assign(number, std::move(answer));
}

void KeptAnswers::ForgetUpTo(int64_t number) {
  answers_.erase(answers_.begin(), answers_.upper_bound(number));
}

const Answer* KeptAnswers::Find(int64_t number) const {
  const auto found = answers_.find(number);
  return found == answers_.end() ? nullptr : &found->second;
}

int64_t KeptAnswers::OldestOr(int64_t none) const {
  return answers_.empty() ? none : answers_.begin()->first;
}

std::string KeptAnswers::Range() const {
  if (answers_.empty()) {
    return "none";
  }
  return absl::StrCat(answers_.begin()->first, " to ", answers_.rbegin()->first);
}

}  // namespace procgen
