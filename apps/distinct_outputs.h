#pragma once

#include <filesystem>
#include <vector>

namespace gluevo::apps {

/// Throws OptionError where two outputs (empty: none) of the command have one name, however it is
/// written, or one lies below the other. Called before any work begins.
void CheckOutputsAreDistinct(const std::vector<std::filesystem::path>& outputs);

/// Throws Error where an output (empty: none) is the same file as an input (empty: none) of the
/// command, under whatever name, or an image or weights in a folder that is one. Called before any
/// work begins.
void CheckOutputsAreNoInputs(const std::vector<std::filesystem::path>& outputs,
                             const std::vector<std::filesystem::path>& inputs);

/// Whether something is a file in a folder or in one below it, links followed.
bool IsFileBelow(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace gluevo::apps
