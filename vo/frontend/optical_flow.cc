#include "gluevo/vo/frontend/optical_flow.h"

#include <opencv2/video/tracking.hpp>

#include "gluevo/vo/core/options_check.h"

namespace gluevo::vo {

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
  cv::calcOpticalFlowPyrLK(from, to, pixels, flow.pixels, flow.found, errors, window,
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

}  // namespace gluevo::vo
