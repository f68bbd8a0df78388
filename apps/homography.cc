#include "homography.h"

#include <cmath>
#include <optional>
#include <sstream>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/whole_file.h"

namespace gluevo::apps {

namespace fs = std::filesystem;

namespace {

std::optional<cv::Matx33d> NineNumbers(const std::string& text) {
  std::istringstream stream(text);
  cv::Matx33d homography;
  for (double& value : homography.val) {
    if (!(stream >> value)) {
      return std::nullopt;
    }
  }
  return homography;
}

std::optional<cv::Matx33d> MatrixOfOpenCv(const std::string& text) {
  try {
    const cv::FileStorage storage(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    for (const cv::FileNode node : storage.root()) {
      cv::Mat matrix;
      node >> matrix;
      if (matrix.rows == 3 && matrix.cols == 3) {
        matrix.convertTo(matrix, CV_64F);
        return cv::Matx33d(matrix.ptr<double>());
      }
    }
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  return std::nullopt;
}

// Of rows of any length, since translations are of thousands of pixels.
bool IsInvertible(const cv::Matx33d& homography) {
  double volume = 1.0;  // Of a box of such sides: what rows at right angles would enclose.
  for (int row = 0; row < 3; ++row) {
    volume *= cv::norm(homography.row(row));
  }
  constexpr double kFlat = 1e-14;
  return std::isfinite(volume) && std::abs(cv::determinant(homography)) > kFlat * volume;
}

}  // namespace

cv::Matx33d ReadHomography(const fs::path& path) {
  const std::string text = vo::ReadWholeFile(path);
  std::optional<cv::Matx33d> homography = NineNumbers(text);
  if (!homography) {
    homography = MatrixOfOpenCv(text);
  }
  if (!homography) {
    throw Error(path.string() +
                ": no homography, expected nine numbers or an OpenCV file with a 3 x 3 matrix");
  }
  if (!IsInvertible(*homography)) {
    throw Error(
        path.string() +
        ": no homography: its matrix has no inverse, expected one that maps the first image "
        "to the second");
  }
  return *homography;
}

int CountNear(const nn::Features& features0, const nn::Features& features1,
              const nn::Matches& matches, const cv::Matx33d& homography, double max_error_px) {
  int right = 0;
  for (int i = 0; i < features0.size(); ++i) {
    if (matches.matches0[i] >= 0) {
      const cv::Vec3d moved =
          homography * cv::Vec3d(features0.keypoints(i, 0), features0.keypoints(i, 1), 1.0);
      const auto mate = features1.keypoints.row(matches.matches0[i]);
      right +=
          std::hypot(moved[0] / moved[2] - mate[0], moved[1] / moved[2] - mate[1]) <= max_error_px
              ? 1
              : 0;
    }
  }
  return right;
}

}  // namespace gluevo::apps
