#ifndef CLIENTS_LIBENV_REPORT_H_
#define CLIENTS_LIBENV_REPORT_H_

#include "absl/strings/string_view.h"

namespace procgen {

// Tells the host's user what is wrong: one line on standard error, in one piece. There is no other
// way, as the interface has no errors.
void Report(absl::string_view message);

}  // namespace procgen

#endif  // CLIENTS_LIBENV_REPORT_H_
