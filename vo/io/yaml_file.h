#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// The map that a text of YAML (or JSON, which is a part of it) holds, also as OpenCV writes and
/// people edit it: with the header "%YAML:1.0", tabs, or no blank between a colon and a list.
/// Throws Error with file and line.
YAML::Node ParseYaml(std::string text, const std::filesystem::path& path);
/// The same of a file.
YAML::Node ReadYaml(const std::filesystem::path& path);

/// The numbers of a list, or of the `data` of an OpenCV matrix. Throws Error naming file and key
/// where the key is missing or does not hold finite numbers, `count` of them where that is above 0.
std::vector<double> YamlNumbers(const YAML::Node& node, const std::string& key, std::size_t count,
                                const std::filesystem::path& path);

/// The text of a key, nothing where it is missing. Throws Error naming file and key for a list or a
/// map.
std::optional<std::string> YamlText(const YAML::Node& node, const std::string& key,
                                    const std::filesystem::path& path);

/// A width or height, pixels. Throws Error naming file and key unless it is a whole positive
/// number.
int YamlSize(double value, const std::string& key, const std::filesystem::path& path);

/// From 12 or 16 numbers, the rows of [R | t]. A rotation of few digits is replaced by the nearest
/// one; where it is off by 0.001 or more, `rounded` (if not null) becomes a sentence that says so.
/// Throws Error naming file and key where it is not near a rotation.
Rigid3 RigidFromRows(const std::vector<double>& numbers, const std::string& key,
                     const std::filesystem::path& path, std::string* rounded = nullptr);

}  // namespace gluevo::vo
