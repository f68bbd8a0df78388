#include "yaml_text.h"

#include <set>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/whole_file.h"

namespace gluevo::apps {
namespace {

std::string Place(const std::filesystem::path& path, const YAML::Mark& mark) {
  return path.string() + ":" + std::to_string(mark.line + 1);
}

}  // namespace

YAML::Node ReadYamlText(const std::filesystem::path& path) {
  const std::string text = vo::ReadWholeFile(path);
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw Error(Place(path, error.mark) + ": not YAML: " + error.msg);
  }
}

std::string YamlPlace(const std::filesystem::path& path, const YAML::Node& node) {
  return Place(path, node.Mark());
}

void CheckKeys(const YAML::Node& map, const std::filesystem::path& path) {
  std::set<std::string> seen;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) {
      throw Error(YamlPlace(path, entry.first) + ": expected a name before the colon");
    }
    if (!seen.insert(entry.first.Scalar()).second) {
      throw Error(YamlPlace(path, entry.first) + ": " + Quoted(entry.first.Scalar()) +
                  " for the second time");
    }
  }
}

}  // namespace gluevo::apps
