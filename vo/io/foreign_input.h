#pragma once

#include <filesystem>
#include <string>
#include <string_view>

// What people name as a data set that is none.
namespace gluevo::vo {

/// What the first bytes of a file tell of it that can be neither text nor an image that was asked
/// for: "a ROS bag", "a NumPy array", "a pointer of Git LFS (fetch ...)", or nothing.
std::string WhatBytesAre(std::string_view beginning);

/// What a file is, by its first bytes and its ending: "a ROS bag", "a zip archive", "an image", or
/// "a file".
std::string WhatFileIs(const std::filesystem::path& file);

/// What a folder that is no data set holds that someone may take for one, for the end of a message:
/// "; V1_01_easy.bag in it is a ROS bag, whose images have to be extracted first", or nothing.
std::string ForeignFilesIn(const std::filesystem::path& folder);

}  // namespace gluevo::vo
