#include "turned_view.h"

#include <opencv2/imgproc.hpp>

#include "gluevo/vo/geometry/projection.h"

namespace gluevo::vo {
namespace {

constexpr float kNowhere = -1e4F;

cv::Point2f TurnPixel(const cv::Point2f& pixel, const Camera& camera,
                      const Eigen::Matrix3d& now_from_last) {
  const Eigen::Vector2d ray = camera.Undistort({pixel.x, pixel.y});
  const Eigen::Vector3d turned = now_from_last * ray.homogeneous();
  // Beyond 80 degrees lenses' models are not to be relied on.
  constexpr double kLeastCosine = 0.17;
  if (!ray.allFinite() || turned.z() < kLeastCosine * turned.norm()) {
    return {kNowhere, kNowhere};
  }
  const Eigen::Vector2d seen = camera.Project(turned);
  return {static_cast<float>(seen.x()), static_cast<float>(seen.y())};
}

}  // namespace

std::vector<cv::Point2f> TurnPixels(const std::vector<cv::Point2f>& pixels, const Camera& camera,
                                    const Eigen::Quaterniond& now_from_last) {
  const Eigen::Matrix3d rotation = now_from_last.toRotationMatrix();
  std::vector<cv::Point2f> turned;
  turned.reserve(pixels.size());
  for (const cv::Point2f& pixel : pixels) {
    turned.push_back(TurnPixel(pixel, camera, rotation));
  }
  return turned;
}

cv::Mat TurnImage(const cv::Mat& image, const Camera& camera,
                  const Eigen::Quaterniond& now_from_last) {
  // Where each pixel comes from is smooth: every eighth is computed.
  constexpr int kStep = 8;
  const Eigen::Matrix3d last_from_now = now_from_last.conjugate().toRotationMatrix();
  const cv::Size coarse((image.cols + kStep - 1) / kStep + 1, (image.rows + kStep - 1) / kStep + 1);
  cv::Mat sources(coarse, CV_32FC2);
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      const cv::Point2f pixel(static_cast<float>(kStep * x), static_cast<float>(kStep * y));
      sources.at<cv::Point2f>(y, x) = TurnPixel(pixel, camera, last_from_now);
    }
  }
  // A full-size pixel (u, v) lies at (u, v) / kStep of the coarse map.
  const double scale = 1.0 / kStep;
  const cv::Matx23d coarse_from_full(scale, 0.0, 0.0, 0.0, scale, 0.0);
  cv::Mat map, turned;
  cv::warpAffine(sources, map, coarse_from_full, image.size(),
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  cv::remap(image, turned, map, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return turned;
}

}  // namespace gluevo::vo
