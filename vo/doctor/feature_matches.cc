#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "checks.h"

namespace gluevo::vo {
namespace {

struct Features {
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
};

Features Detect(const cv::Mat& image) {
  // Few levels: a point of a coarse one is known to several pixels only.
  constexpr int kFeatures = 1500;
  constexpr float kScale = 1.2F;
  constexpr int kLevels = 3;
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(kFeatures, kScale, kLevels);
  Features features;
  orb->detectAndCompute(image, cv::noArray(), features.points, features.descriptors);
  return features;
}

/// The index in b of each of a's features' distinct match, or -1.
std::vector<int> Nearest(const Features& a, const Features& b) {
  constexpr float kDistinct = 0.8F;  // Lowe 2004
  std::vector<int> nearest(a.points.size(), -1);
  std::vector<std::vector<cv::DMatch>> candidates;
  cv::BFMatcher(cv::NORM_HAMMING).knnMatch(a.descriptors, b.descriptors, candidates, 2);
  for (const std::vector<cv::DMatch>& two : candidates) {
    if (two.size() == 2 && two[0].distance < kDistinct * two[1].distance) {
      nearest[static_cast<std::size_t>(two[0].queryIdx)] = two[0].trainIdx;
    }
  }
  return nearest;
}

}  // namespace

std::vector<PixelMatch> MatchFeatures(const cv::Mat& left, const cv::Mat& right) {
  constexpr std::size_t kFewest = 15;
  const Features left_features = Detect(left);
  const Features right_features = Detect(right);
  if (left_features.points.size() < kFewest || right_features.points.size() < kFewest) {
    return {};
  }
  const std::vector<int> forth = Nearest(left_features, right_features);
  const std::vector<int> back = Nearest(right_features, left_features);
  std::vector<cv::Point2f> left_points;
  std::vector<cv::Point2f> right_points;
  for (std::size_t i = 0; i < forth.size(); ++i) {
    if (forth[i] >= 0 && back[static_cast<std::size_t>(forth[i])] == static_cast<int>(i)) {
      left_points.push_back(left_features.points[i].pt);
      right_points.push_back(right_features.points[static_cast<std::size_t>(forth[i])].pt);
    }
  }
  if (left_points.size() < kFewest) {
    return {};
  }
  // Whatever the calibration says, true matches share one epipolar geometry (the distortion bends
  // it by a pixel or two) and false ones do not.
  constexpr double kThreshold = 3.0;
  constexpr double kConfidence = 0.999;
  cv::Mat inliers;
  cv::findFundamentalMat(left_points, right_points, cv::FM_RANSAC, kThreshold, kConfidence,
                         inliers);
  std::vector<PixelMatch> matches;
  for (std::size_t i = 0; i < left_points.size() && !inliers.empty(); ++i) {
    if (inliers.at<unsigned char>(static_cast<int>(i)) != 0) {
      matches.push_back(
          {{left_points[i].x, left_points[i].y}, {right_points[i].x, right_points[i].y}});
    }
  }
  return matches.size() >= kFewest ? matches : std::vector<PixelMatch>();
}

}  // namespace gluevo::vo
