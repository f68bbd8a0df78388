#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

namespace gluevo::nn {

/// A file's bytes in memory.
struct InputFile {
  std::unique_ptr<char[]> data;
  std::size_t size = 0;
};

/// Throws Error naming the file where there is none or it cannot be read whole, and
/// where it is larger than any weights (4 GiB).
InputFile ReadInputFile(const std::filesystem::path& path);

/// SHA-256, lower-case hexadecimal.
std::string Sha256(const void* bytes, std::size_t size);

}  // namespace gluevo::nn
