#include "yaml_file.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "gluevo/nn/error.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// Matrices and camera files have some ten. Aliases could make a list endless.
constexpr int kMostItems = 1000;
constexpr int kDeepestList = 4;

void AppendNumbers(const YAML::Node& item, const std::string& where, int depth, int& items,
                   std::vector<double>& numbers) {
  if (++items > kMostItems || depth > kDeepestList) {
    throw Error(where + " is too long a list");
  }
  if (item.IsSequence()) {
    for (const YAML::Node& inner : item) {
      AppendNumbers(inner, where, depth + 1, items, numbers);
    }
    return;
  }
  const std::optional<double> number = item.IsScalar() ? ParseNumber(item.Scalar()) : std::nullopt;
  if (!number) {
    throw Error(where + " is not a list of finite numbers");
  }
  numbers.push_back(*number);
}

// The nearest rotation (in the sense of the Frobenius norm).
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace

YAML::Node ParseYaml(std::string text, const fs::path& path) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) {
    text.erase(0, kByteOrderMark.size());
  }
  // OpenCV's header is no YAML directive: read as a comment, it does no harm.
  if (text.starts_with("%YAML:")) {
    text.front() = '#';
  }
  const bool is_json = text.find_first_not_of(" \t\r\n") != std::string::npos &&
                       text[text.find_first_not_of(" \t\r\n")] == '{';
  std::replace(text.begin(), text.end(), '\t', ' ');
  // Old Macs end lines with a carriage return alone.
  if (text.find('\n') == std::string::npos) {
    std::replace(text.begin(), text.end(), '\r', '\n');
  }
  for (std::size_t i = text.find(":["); i != std::string::npos; i = text.find(":[", i)) {
    text.insert(i + 1, 1, ' ');
  }
  try {
    YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) {
      throw Error(path.string() + ": expected a YAML map");
    }
    return root;
  } catch (const YAML::Exception& error) {
    throw Error(path.string() + ":" + std::to_string(error.mark.line + 1) + ": not " +
                (is_json ? "JSON" : "YAML") + ": " + error.msg);
  }
}

YAML::Node ReadYaml(const fs::path& path) { return ParseYaml(ReadText(path), path); }

std::vector<double> YamlNumbers(const YAML::Node& node, const std::string& key, std::size_t count,
                                const fs::path& path) {
  YAML::Node list = node[key];
  if (!list) {
    throw Error(path.string() + ": no " + key);
  }
  if (list.IsMap()) {
    list.reset(list["data"]);
  }
  std::vector<double> numbers;
  int items = 0;
  AppendNumbers(list, path.string() + ": " + key, 0, items, numbers);
  if (count > 0 && numbers.size() != count) {
    throw Error(path.string() + ": " + key + " has " + std::to_string(numbers.size()) +
                " numbers, expected " + std::to_string(count));
  }
  return numbers;
}

Rigid3 RigidFromRows(const std::vector<double>& numbers, const std::string& key,
                     const fs::path& path, std::string* rounded) {
  if (numbers.size() != 12 && numbers.size() != 16) {
    throw Error(path.string() + ": " + key + " has " + std::to_string(numbers.size()) +
                " numbers, expected a 4 x 4 matrix");
  }
  constexpr double kRounding = 1e-9;
  const std::array<double, 4> last_row = {0.0, 0.0, 0.0, 1.0};
  if (numbers.size() == 16 &&
      !std::equal(last_row.begin(), last_row.end(), numbers.begin() + 12,
                  [&](double a, double b) { return std::abs(a - b) <= kRounding; })) {
    throw Error(path.string() + ": the last row of " + key + " is not 0 0 0 1");
  }
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(numbers.data());
  Eigen::Matrix3d rotation = matrix.leftCols<3>();
  const double off = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  // Two digits after the point are off by 0.03 at most.
  constexpr double kTooFar = 0.06;
  if (!(off < kTooFar && rotation.determinant() > 0.0)) {
    throw Error(path.string() + ": " + key +
                " is not a rigid transform: its first three columns are not near a rotation");
  }
  // Six digits and more are as they were written.
  constexpr double kRounded = 1e-5;
  constexpr double kWorthSaying = 1e-3;
  if (off > kRounded) {
    rotation = NearestRotation(rotation);
  }
  if (off > kWorthSaying && rounded != nullptr) {
    *rounded = "the rotation in " + key + " is off by " + std::to_string(off) +
               " (few digits?); the nearest rotation is taken";
  }
  return {Eigen::Quaterniond(rotation).normalized(), matrix.col(3)};
}

std::optional<std::string> YamlText(const YAML::Node& node, const std::string& key,
                                    const fs::path& path) {
  const YAML::Node text = node[key];
  if (!text) {
    return std::nullopt;
  }
  if (!text.IsScalar()) {
    throw Error(path.string() + ": " + key + " is not a name");
  }
  return text.Scalar();
}

int YamlSize(double value, const std::string& key, const fs::path& path) {
  constexpr double kLargest = 1 << 20;
  if (!(value >= 1.0 && value <= kLargest) || value != std::floor(value)) {
    throw Error(path.string() + ": " + key + " is no size of an image in pixels");
  }
  return static_cast<int>(value);
}

}  // namespace gluevo::vo
