#pragma once

#include <initializer_list>
#include <string>

namespace gluevo::vo {

/// Throws Error naming the option and what is expected where the value is none of these.
void CheckName(const std::string& value, std::initializer_list<const char*> expected,
               const std::string& option);

}  // namespace gluevo::vo
