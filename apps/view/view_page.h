#pragma once

#include <string_view>

namespace gluevo::apps {

/// page.html as it is: one file that asks for nothing but /stream.
std::string_view ViewPage();

}  // namespace gluevo::apps
