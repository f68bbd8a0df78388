#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "gluevo/vo/geometry/camera.h"

namespace gluevo::vo {

/// Where a camera that was turned would see what it sees at `pixels`: `now_from_last` takes its
/// directions before to those after. Far outside of the image where it would not see it.
std::vector<cv::Point2f> TurnPixels(const std::vector<cv::Point2f>& pixels, const Camera& camera,
                                    const Eigen::Quaterniond& now_from_last);

/// The image as the camera would have seen it had it been turned: black where it saw nothing.
cv::Mat TurnImage(const cv::Mat& image, const Camera& camera,
                  const Eigen::Quaterniond& now_from_last);

}  // namespace gluevo::vo
