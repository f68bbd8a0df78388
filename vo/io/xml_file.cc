#include "xml_file.h"

#include <algorithm>
#include <cstring>
#include <pugixml.hpp>
#include <sstream>

#include "gluevo/nn/error.h"

// Read with pugixml: OpenCV's own parser crashes on files that are broken.
namespace gluevo::vo {
namespace {

YAML::Node ScalarOrList(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::string> items;
  for (std::string word; words >> word;) {
    items.push_back(word);
  }
  if (items.size() > 1 && items.front().front() != '"') {
    return YAML::Node(items);
  }
  const std::size_t begin = text.find_first_not_of(" \t\r\n\"");
  const std::size_t end = text.find_last_not_of(" \t\r\n\"");
  return begin == std::string::npos ? YAML::Node()
                                    : YAML::Node(text.substr(begin, end + 1 - begin));
}

/// Elements called "_" are the items of a list.
YAML::Node TreeOf(const pugi::xml_node& element) {
  const pugi::xml_node first = element.find_child(
      [](const pugi::xml_node& child) { return child.type() == pugi::node_element; });
  if (!first) {
    return ScalarOrList(element.text().get());
  }
  const bool is_list = std::strcmp(first.name(), "_") == 0;
  YAML::Node tree(is_list ? YAML::NodeType::Sequence : YAML::NodeType::Map);
  for (const pugi::xml_node& child : element.children()) {
    if (child.type() != pugi::node_element) {
      continue;
    }
    if (is_list) {
      tree.push_back(TreeOf(child));
    } else {
      tree[std::string(child.name())] = TreeOf(child);
    }
  }
  return tree;
}

}  // namespace

YAML::Node ParseOpenCvXml(const std::string& text, const std::filesystem::path& path) {
  // The tree is gone down with each element.
  constexpr std::ptrdiff_t kMostElements = 2000;
  if (std::count(text.begin(), text.end(), '<') > kMostElements) {
    throw Error(path.string() + ": not a calibration: more than " + std::to_string(kMostElements) +
                " XML elements");
  }
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
  if (!result) {
    throw Error(path.string() + ": byte " + std::to_string(result.offset) +
                ": not OpenCV's XML storage: " + result.description());
  }
  const pugi::xml_node storage = document.child("opencv_storage");
  YAML::Node tree = storage ? TreeOf(storage) : YAML::Node();
  if (!tree.IsMap()) {
    throw Error(path.string() + ": no map of OpenCV's XML storage (opencv_storage)");
  }
  return tree;
}

}  // namespace gluevo::vo
