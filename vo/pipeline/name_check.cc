#include "name_check.h"

#include <algorithm>

#include "gluevo/nn/option_error.h"

namespace gluevo::vo {

void CheckName(const std::string& value, std::initializer_list<const char*> expected,
               const std::string& option) {
  if (std::find(expected.begin(), expected.end(), value) != expected.end()) {
    return;
  }
  std::string names;
  for (const char* const name : expected) {
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  throw OptionError("option " + option + " is " + Quoted(value) + "; expected one of " + names);
}

}  // namespace gluevo::vo
