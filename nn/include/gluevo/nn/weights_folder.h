#pragma once

#include <filesystem>

namespace gluevo::nn {

/// Where a user's own weights lie: $XDG_DATA_HOME/gluevo/weights, else
/// ~/.local/share/gluevo/weights (XDG Base Directory Specification, which passes over relative
/// paths). Empty where the environment names no home. The folder need not be there.
std::filesystem::path UserWeightsFolder();

}  // namespace gluevo::nn
