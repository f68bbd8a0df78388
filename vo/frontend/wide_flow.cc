#include "wide_flow.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "gluevo/vo/core/median.h"

namespace gluevo::vo {
namespace {

struct Displacement {
  cv::Point2f from;
  cv::Point2f by;
};

std::vector<Displacement> MatchByDescriptors(const cv::Mat& from, const cv::Mat& to) {
  constexpr int kMostCorners = 1500;
  constexpr float kScale = 1.2F;
  constexpr int kLevels = 8;
  constexpr double kEpipolarErrorPx = 2.0;
  constexpr double kConfidence = 0.999;
  constexpr std::size_t kFewest = 15;
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(kMostCorners, kScale, kLevels);
  std::vector<cv::KeyPoint> corners[2];
  cv::Mat descriptors[2];
  orb->detectAndCompute(from, cv::noArray(), corners[0], descriptors[0]);
  orb->detectAndCompute(to, cv::noArray(), corners[1], descriptors[1]);
  std::vector<cv::DMatch> matches;
  if (!descriptors[0].empty() && !descriptors[1].empty()) {
    cv::BFMatcher(cv::NORM_HAMMING, /*crossCheck=*/true)
        .match(descriptors[0], descriptors[1], matches);
  }
  if (matches.size() < kFewest) {
    return {};
  }
  std::vector<cv::Point2f> points[2];
  for (const cv::DMatch& match : matches) {
    points[0].push_back(corners[0][match.queryIdx].pt);
    points[1].push_back(corners[1][match.trainIdx].pt);
  }
  std::vector<uchar> agrees;
  cv::findFundamentalMat(points[0], points[1], cv::FM_RANSAC, kEpipolarErrorPx, kConfidence,
                         agrees);
  std::vector<Displacement> displacements;
  for (std::size_t i = 0; i < agrees.size(); ++i) {
    if (agrees[i] != 0) {
      displacements.push_back({points[0][i], points[1][i] - points[0][i]});
    }
  }
  return displacements;
}

}  // namespace

std::vector<cv::Point2f> GuessByDescriptors(const cv::Mat& from, const cv::Mat& to,
                                            const std::vector<cv::Point2f>& pixels,
                                            const std::vector<cv::Point2f>& guesses) {
  constexpr float kAroundShare = 0.08F;  // Of the image's width.
  const float around = kAroundShare * static_cast<float>(from.cols);
  const std::vector<Displacement> displacements = MatchByDescriptors(from, to);
  std::vector<cv::Point2f> moved = guesses;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    std::vector<double> by_x, by_y;
    for (const Displacement& displacement : displacements) {
      const cv::Point2f offset = displacement.from - pixels[i];
      if (offset.dot(offset) < around * around) {
        by_x.push_back(displacement.by.x);
        by_y.push_back(displacement.by.y);
      }
    }
    if (!by_x.empty()) {
      moved[i] = pixels[i] +
                 cv::Point2f(static_cast<float>(Median(by_x)), static_cast<float>(Median(by_y)));
    }
  }
  return moved;
}

}  // namespace gluevo::vo
