#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace gluevo::nn {

/// What HDF5 files begin with.
inline constexpr std::string_view kHdf5Mark = "\x89HDF\r\n";

/// Whether a file has these words, or this signature, in its first 200 bytes.
bool HasMark(const std::filesystem::path& file, std::string_view mark);

/// Throws Error where a file is at the place of an output, is not empty and has no such mark:
/// `kind`, "an SVG file", is what the output is. So no mistyped name costs a file of another kind.
void CheckReplacesOnly(const std::filesystem::path& output, std::string_view mark,
                       const std::string& kind);

}  // namespace gluevo::nn
