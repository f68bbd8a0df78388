#include "gluevo/vo/frontend/optical_flow.h"

#include <cmath>
#include <limits>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "gluevo/vo/core/median.h"
#include "gluevo/vo/core/options_check.h"

namespace gluevo::vo {
namespace {

// Of where a patch is found, along the worse axis, pixels, for noise of one gray level.
// `gradients`: a pyramid's, by Scharr's filter.
double SigmaOfUnitNoise(const cv::Mat& gradients, const cv::Point2f& pixel, int window) {
  constexpr double kScharr = 32.0;  // What it gives for one gray level a pixel.
  const cv::Rect image(0, 0, gradients.cols, gradients.rows);
  const cv::Rect patch = image & cv::Rect(cvRound(pixel.x) - window / 2,
                                          cvRound(pixel.y) - window / 2, window, window);
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (int y = patch.y; y < patch.y + patch.height; ++y) {
    for (int x = patch.x; x < patch.x + patch.width; ++x) {
      const auto& gradient = gradients.at<cv::Vec<short, 2>>(y, x);
      xx += gradient[0] * gradient[0];
      xy += gradient[0] * gradient[1];
      yy += gradient[1] * gradient[1];
    }
  }
  const double least = 0.5 * (xx + yy - std::hypot(xx - yy, 2.0 * xy));
  return least > 0.0 ? kScharr / std::sqrt(least) : std::numeric_limits<double>::infinity();
}

}  // namespace

void FlowOptions::Validate(const std::string& name) const {
  CheckAtLeast(window, 3, name + ".window");
  CheckAtLeast(levels, 0, name + ".levels");
  CheckAtLeast(levels_back, 0, name + ".levels_back");
  CheckPositive(max_return_distance, name + ".max_return_distance");
}

Pyramid MakePyramid(const cv::Mat& image, int window, int levels) {
  Pyramid pyramid;
  RemakePyramid(image, window, levels, pyramid);
  return pyramid;
}

void RemakePyramid(const cv::Mat& image, int window, int levels, Pyramid& pyramid) {
  constexpr bool kReuseInput = false;
  cv::buildOpticalFlowPyramid(image, pyramid, {window, window}, levels, /*withDerivatives=*/true,
                              cv::BORDER_REFLECT_101, cv::BORDER_CONSTANT, kReuseInput);
}

Flow FollowBothWays(const Pyramid& from, const Pyramid& to, const std::vector<cv::Point2f>& pixels,
                    const std::vector<cv::Point2f>& guesses, const FlowOptions& options) {
  Flow flow{guesses, std::vector<unsigned char>(pixels.size(), 0)};
  if (pixels.empty()) {
    return flow;
  }
  const cv::Size window(options.window, options.window);
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01);
  std::vector<float> errors;
  cv::calcOpticalFlowPyrLK(from, to, pixels, flow.pixels, flow.found, flow.differences, window,
                           options.levels, criteria, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<cv::Point2f> returned = pixels;
  std::vector<unsigned char> found_back;
  cv::calcOpticalFlowPyrLK(to, from, flow.pixels, returned, found_back, errors, window,
                           options.levels_back, criteria, cv::OPTFLOW_USE_INITIAL_FLOW);
  const cv::Rect2f inside(0.0F, 0.0F, static_cast<float>(to.front().cols - 1),
                          static_cast<float>(to.front().rows - 1));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const cv::Point2f miss = returned[i] - pixels[i];
    flow.found[i] = flow.found[i] != 0 && found_back[i] != 0 && inside.contains(flow.pixels[i]) &&
                    miss.dot(miss) <= options.max_return_distance * options.max_return_distance;
  }
  return flow;
}

double MedianFlowSigma(const Pyramid& from, const std::vector<cv::Point2f>& pixels,
                       const Flow& flow, int window) {
  constexpr double kOfMeanDifference = 1.2533;  // Sigma of normal noise.
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (flow.found[i] != 0) {
      sigmas.push_back(kOfMeanDifference * flow.differences[i] *
                       SigmaOfUnitNoise(from[1], pixels[i], window));
    }
  }
  return sigmas.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(sigmas));
}

Flow FollowFinely(const Pyramid& from, const Pyramid& to, const std::vector<cv::Point2f>& pixels,
                  const Flow& coarse, const FlowOptions& options, double max_distance_px) {
  Flow fine = FollowBothWays(from, to, pixels, coarse.pixels, options);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const cv::Point2f by = fine.pixels[i] - coarse.pixels[i];
    fine.found[i] = coarse.found[i] != 0 && fine.found[i] != 0 &&
                    by.dot(by) <= max_distance_px * max_distance_px;
  }
  return fine;
}

}  // namespace gluevo::vo
