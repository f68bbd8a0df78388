#pragma once

#include <optional>
#include <string_view>

namespace gluevo::nn {

/// What lies in place of a file that never came: a pointer of Git LFS or git-annex, or a page that
/// was saved when the file should have been downloaded.
struct StandIn {
  const char* what;    ///< "a web page"
  const char* advice;  ///< What to do about it, "fetch the file itself with git lfs pull".
  bool is_page = false;
};

/// By the first bytes of a file (some hundred suffice); nothing for all others.
std::optional<StandIn> FindStandIn(std::string_view beginning);

}  // namespace gluevo::nn
