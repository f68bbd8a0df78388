#include "xml_file.h"

#include <algorithm>
#include <limits>
#include <opencv2/core.hpp>
#include <sstream>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

YAML::Node TreeOf(const cv::FileNode& node) {
  if (node.isMap()) {
    YAML::Node map(YAML::NodeType::Map);
    for (const cv::FileNode& child : node) {
      map[child.name()] = TreeOf(child);
    }
    return map;
  }
  if (node.isSeq()) {
    YAML::Node list(YAML::NodeType::Sequence);
    for (const cv::FileNode& child : node) {
      list.push_back(TreeOf(child));
    }
    return list;
  }
  if (node.isInt()) {
    return YAML::Node(static_cast<int>(node));
  }
  if (node.isReal()) {
    std::ostringstream text;
    text.precision(std::numeric_limits<double>::max_digits10);
    text << static_cast<double>(node);
    return YAML::Node(text.str());
  }
  return node.isString() ? YAML::Node(static_cast<std::string>(node)) : YAML::Node();
}

}  // namespace

YAML::Node ParseOpenCvXml(const std::string& text, const std::filesystem::path& path) {
  // OpenCV's parser and ours go down with each element.
  constexpr std::ptrdiff_t kMostElements = 2000;
  if (std::count(text.begin(), text.end(), '<') > kMostElements) {
    throw Error(path.string() + ": not a calibration: more than " + std::to_string(kMostElements) +
                " XML elements");
  }
  try {
    const cv::FileStorage storage(
        text, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_XML);
    YAML::Node tree = TreeOf(storage.root());
    if (!tree.IsMap()) {
      throw Error(path.string() + ": no map of OpenCV's XML storage (opencv_storage)");
    }
    return tree;
  } catch (const cv::Exception& error) {
    throw Error(path.string() + ": not OpenCV's XML storage: " + error.err);
  }
}

}  // namespace gluevo::vo
