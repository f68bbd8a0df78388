#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace gluevo::vo {

/// Pyramidal Lucas-Kanade (Bouguet 2001) with a check in both directions.
struct FlowOptions {
  /// Side of the patch that is followed, pixels.
  int window = 21;
  /// Coarser pyramid levels, forth and back.
  int levels = 1;
  int levels_back = 1;
  /// A point followed forth and back must return this close to where it was, pixels.
  double max_return_distance = 0.5;

  /// Throws Error naming the option, which is called after `name`.
  void Validate(const std::string& name) const;
};

/// An image in several sizes, with its derivatives, as following points in it wants it.
using Pyramid = std::vector<cv::Mat>;
/// `image`: CV_8UC1. Nothing of it is kept: its memory may be used again.
Pyramid MakePyramid(const cv::Mat& image, int window, int levels);
/// The same in the memory of an old pyramid that nobody shares: new memory for every image costs a
/// tenth of the klt front end's time.
void RemakePyramid(const cv::Mat& image, int window, int levels, Pyramid& pyramid);

inline Eigen::Vector2d ToEigen(const cv::Point2f& point) { return {point.x, point.y}; }

/// Where points of one image are in another, pixels, and which of them were found (else 0).
struct Flow {
  std::vector<cv::Point2f> pixels;
  std::vector<unsigned char> found;
  /// How far the patches around both differ, forth, mean over the patch, gray levels.
  std::vector<float> differences = {};
};

/// Follows `pixels` from one image to another; the search begins at `guesses`, one each. Pyramids
/// of at least the options' window; where they have fewer levels, these.
Flow FollowBothWays(const Pyramid& from, const Pyramid& to, const std::vector<cv::Point2f>& pixels,
                    const std::vector<cv::Point2f>& guesses, const FlowOptions& options);

/// How far off such a patch around each of the points is found where images have noise, one
/// standard deviation along the worse axis, pixels: by the gray values' gradients in `from` and by
/// how much the patches of `flow` differ (the Cramer-Rao bound of Lucas and Kanade's equations).
/// Median over the points that `flow` found; infinite where it found none.
double MedianFlowSigma(const Pyramid& from, const std::vector<cv::Point2f>& pixels,
                       const Flow& flow, int window);

/// Follows on, with a patch that is smaller and so sees less of what lies behind the point, from
/// where `coarse` ends: what it does not find within `max_distance_px` of there is lost.
Flow FollowFinely(const Pyramid& from, const Pyramid& to, const std::vector<cv::Point2f>& pixels,
                  const Flow& coarse, const FlowOptions& options, double max_distance_px);

}  // namespace gluevo::vo
