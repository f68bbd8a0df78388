#pragma once

#include <filesystem>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::vo {

/// Makes a directory and those above it where they do not exist. Throws Error where it cannot.
inline void MakeOutputDirectory(const std::filesystem::path& directory) {
  std::error_code code;
  std::filesystem::create_directories(directory, code);
  if (code) {
    throw Error(directory.string() + ": cannot be made: " + code.message());
  }
}

}  // namespace gluevo::vo
