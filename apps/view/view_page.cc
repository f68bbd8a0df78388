#include "view_page.h"

#include <cstddef>

extern "C" {
extern const char gluevo_view_page_begin[];
extern const char gluevo_view_page_end[];
}

namespace gluevo::apps {

std::string_view ViewPage() {
  return {gluevo_view_page_begin,
          static_cast<std::size_t>(gluevo_view_page_end - gluevo_view_page_begin)};
}

}  // namespace gluevo::apps
