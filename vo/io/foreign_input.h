#pragma once

#include <filesystem>
#include <string>

// What people name as a data set that is none.
namespace gluevo::vo {

/// What a file is, by its first bytes and its ending: "a ROS bag", "a zip archive", "an image", or
/// "a file".
std::string WhatFileIs(const std::filesystem::path& file);

/// What a folder that is no data set holds that someone may take for one, for the end of a message:
/// "; V1_01_easy.bag in it is a ROS bag, whose images have to be extracted first", or nothing.
std::string ForeignFilesIn(const std::filesystem::path& folder);

}  // namespace gluevo::vo
