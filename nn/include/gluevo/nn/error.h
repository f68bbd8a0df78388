#pragma once

#include <stdexcept>

namespace gluevo {

/// Bad input or a failed run, thrown by every layer. The message is one line that a user can act
/// on: what is wrong, in which file (and at which offset) or option, and what was expected.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace gluevo
