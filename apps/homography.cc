#include "homography.h"

#include <cmath>
#include <fstream>

#include "gluevo/nn/error.h"

namespace gluevo::apps {

namespace fs = std::filesystem;

cv::Matx33d ReadHomography(const fs::path& path) {
  const auto fail = [&]() -> cv::Matx33d {
    throw Error(path.string() +
                ": no homography, expected nine numbers or an OpenCV file with a 3 x 3 matrix");
  };
  cv::Matx33d homography;
  std::ifstream file(path);
  int count = 0;
  while (count < 9 && file >> homography.val[count]) {
    ++count;
  }
  if (count == 9) {
    return homography;
  }
  try {
    const cv::FileStorage storage(path.string(), cv::FileStorage::READ);
    cv::Mat matrix;
    for (const cv::FileNode node : storage.root()) {
      node >> matrix;
      if (matrix.rows == 3 && matrix.cols == 3) {
        matrix.convertTo(matrix, CV_64F);
        return cv::Matx33d(matrix.ptr<double>());
      }
    }
  } catch (const cv::Exception&) {
    return fail();
  }
  return fail();
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
