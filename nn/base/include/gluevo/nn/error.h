#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace gluevo {

/// Bad input or a failed run, thrown by every layer. The message is one line that a user can act
/// on: what is wrong, in which file (and at which offset) or option, and what was expected.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Text out of a file as it may stand in a one-line message: in double quotes, anything that is not
/// printable ASCII as \xNN, at most 100 characters of it.
std::string Quoted(std::string_view text);

}  // namespace gluevo
