#pragma once

#include <filesystem>
#include <string>

namespace gluevo::vo {

/// All bytes of a file, a pipe included. Throws Error naming the file, and saying why, where it
/// cannot be opened or, at whatever place, read: a folder, a bad sector, a network that is down.
std::string ReadWholeFile(const std::filesystem::path& path);

}  // namespace gluevo::vo
