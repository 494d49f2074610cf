#ifndef CLIENTS_LIBENV_REPORT_H_
#define CLIENTS_LIBENV_REPORT_H_

#include "absl/strings/string_view.h"

namespace procgen {

// Writes one line to standard error in a single call. The interface has no other way to report
// errors.
void Report(absl::string_view message);

}  // namespace procgen

#endif  // CLIENTS_LIBENV_REPORT_H_
