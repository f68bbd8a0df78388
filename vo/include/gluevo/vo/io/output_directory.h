#pragma once

#include <filesystem>

namespace gluevo::vo {

/// Makes a directory and those above it where they do not exist. Throws Error where it cannot,
/// where something else has the name, and where no file can be made in it: whoever calls this first
/// computes nothing that cannot be kept.
void MakeOutputDirectory(const std::filesystem::path& directory);

}  // namespace gluevo::vo
