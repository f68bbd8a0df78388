#pragma once

#include <Eigen/Core>
#include <vector>

namespace gluevo::nn {

/// Keypoints of one image with what the networks know of them. Row i of every member belongs to
/// keypoint i.
struct Features {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using Points = Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>;

  /// Size of the image in pixels.
  int width = 0;
  int height = 0;
  /// N x 2: x (right) and y (down) in pixels, the centre of the top-left pixel being (0, 0).
  Points keypoints;
  /// N: SuperPoint's confidence, 0 to 1.
  Eigen::VectorXf scores;
  /// N x D, each row of unit length.
  RowMajor descriptors;

  int size() const { return static_cast<int>(keypoints.rows()); }
};

/// Matches from the keypoints of image 0 to those of image 1.
struct Matches {
  /// For each keypoint of image 0 its index in image 1, or -1.
  std::vector<int> matches0;
  /// Confidence of each, 0 to 1; 0 where there is none.
  std::vector<float> scores0;
};

}  // namespace gluevo::nn
