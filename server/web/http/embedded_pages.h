#ifndef SERVER_WEB_HTTP_EMBEDDED_PAGES_H_
#define SERVER_WEB_HTTP_EMBEDDED_PAGES_H_

#include <vector>

#include "absl/strings/string_view.h"

namespace procgen::web {

// A file of pages/, embedded at build time.
struct EmbeddedPage {
  absl::string_view name;  // path in pages/, such as "vendor/plot.js"
  absl::string_view contents;
};

std::vector<EmbeddedPage> EmbeddedPages();

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_EMBEDDED_PAGES_H_
