#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace gluevo::vo {

/// Where points of one image may be in another that is seconds later, pixels: optical flow can
/// start there, which finds nothing by itself that moved by half of the image. Corners of both are
/// matched by ORB descriptors (Rublee et al. 2011), of which those stay that agree on an epipolar
/// geometry, and each point moves as the matches around it do. Points that have none around them
/// stay at their guesses. The same input gives the same result.
std::vector<cv::Point2f> GuessByDescriptors(const cv::Mat& from, const cv::Mat& to,
                                            const std::vector<cv::Point2f>& pixels,
                                            const std::vector<cv::Point2f>& guesses);

}  // namespace gluevo::vo
