#pragma once

#include <filesystem>
#include <string>

namespace gluevo::vo {

/// All bytes of a file, a pipe included. Throws Error naming the file, and saying why, where it
/// cannot be opened or, at whatever place, read: a folder, a device (which may have no end), a bad
/// sector, a network that is down.
std::string ReadWholeFile(const std::filesystem::path& path);

/// What is wrong with a path at which no file is, as messages end.
std::string WhyNoFile(const std::filesystem::path& path);

}  // namespace gluevo::vo
