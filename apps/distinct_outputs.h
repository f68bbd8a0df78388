#pragma once

#include <filesystem>
#include <vector>

namespace gluevo::apps {

/// Throws Error where an output (empty: none) is the same file as an input (empty: none) of the
/// command, under whatever name, or an image in a folder that is one. Called before any work
/// begins.
void CheckOutputsAreNoInputs(const std::vector<std::filesystem::path>& outputs,
                             const std::vector<std::filesystem::path>& inputs);

}  // namespace gluevo::apps
