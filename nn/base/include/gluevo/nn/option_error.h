#pragma once

#include "gluevo/nn/error.h"

namespace gluevo {

/// A value that an option does not take, or that does not go with another's: all that the caller
/// alone can have wrong, whatever the files hold. Programs end with the exit code of bad usage.
class OptionError : public Error {
 public:
  using Error::Error;
};

}  // namespace gluevo
