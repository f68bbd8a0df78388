#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>

namespace gluevo::apps {

/// A file that people write: what it holds. Throws Error naming the file, and the line where it is
/// no YAML.
YAML::Node ReadYamlText(const std::filesystem::path& path);

/// "FILE:LINE" of something in it.
std::string YamlPlace(const std::filesystem::path& path, const YAML::Node& node);

/// Throws Error naming file and line where a key of a map is no name, or occurs twice, which
/// yaml-cpp lets pass.
void CheckKeys(const YAML::Node& map, const std::filesystem::path& path);

}  // namespace gluevo::apps
