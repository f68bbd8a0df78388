#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>

namespace gluevo::vo {

/// The map that OpenCV's XML storage holds, as the same file in YAML would be read. Throws Error
/// with the file.
YAML::Node ParseOpenCvXml(const std::string& text, const std::filesystem::path& path);

}  // namespace gluevo::vo
