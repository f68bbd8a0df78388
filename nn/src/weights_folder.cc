#include "gluevo/nn/weights_folder.h"

#include <cstdlib>

namespace gluevo::nn {
namespace {

// Empty where the variable is not set to an absolute path.
std::filesystem::path FolderIn(const char* variable) {
  const char* const value = std::getenv(variable);
  const std::filesystem::path folder = value != nullptr ? value : "";
  return folder.is_absolute() ? folder : std::filesystem::path();
}

}  // namespace

std::filesystem::path UserWeightsFolder() {
  std::filesystem::path data = FolderIn("XDG_DATA_HOME");
  if (const std::filesystem::path home = FolderIn("HOME"); data.empty() && !home.empty()) {
    data = home / ".local" / "share";
  }
  return data.empty() ? data : data / "gluevo" / "weights";
}

}  // namespace gluevo::nn
