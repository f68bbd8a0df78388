#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <utility>
#include <vector>

#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/geometry/stereo_rig.h"

/// Networks that do what a test tells them.
namespace gluevo::vo::testing {

/// 64 x 48 pixels, focal length 50, baseline 0.1 m.
inline StereoRig RectifiedRig() {
  StereoRig rig;
  for (Camera& camera : rig.cameras) {
    camera = {.width = 64, .height = 48, .fx = 50.0, .fy = 50.0, .cx = 32.0, .cy = 24.0};
  }
  rig.body_from_cam[1].translation = {0.1, 0.0, 0.0};
  return rig;
}

/// Gives the features it is told, in order.
class ScriptedExtractor : public FeatureExtractor {
 public:
  explicit ScriptedExtractor(std::deque<nn::Features> script) : script_(std::move(script)) {}
  nn::Features Extract(const cv::Mat& /*image*/) override {
    nn::Features features = script_.front();
    script_.pop_front();
    return features;
  }
  nn::Features Describe(const cv::Mat& /*image*/, const nn::Features::Points& /*pixels*/) override {
    return Extract({});
  }

 private:
  std::deque<nn::Features> script_;
};

/// Matches keypoints with the same score: the tests use scores as names.
class NameMatcher : public Matcher {
 public:
  nn::Matches Match(const nn::Features& a, const nn::Features& b, float /*threshold*/) override {
    nn::Matches matches;
    matches.matches0.assign(static_cast<std::size_t>(a.size()), -1);
    matches.scores0.assign(static_cast<std::size_t>(a.size()), 0.0F);
    for (int i = 0; i < a.size(); ++i) {
      for (int j = 0; j < b.size(); ++j) {
        if (a.scores[i] == b.scores[j]) {
          matches.matches0[static_cast<std::size_t>(i)] = j;
          matches.scores0[static_cast<std::size_t>(i)] = 0.9F;
        }
      }
    }
    return matches;
  }
};

class NoMatcher : public Matcher {
 public:
  nn::Matches Match(const nn::Features& a, const nn::Features& /*b*/, float /*t*/) override {
    const auto size = static_cast<std::size_t>(a.size());
    return {std::vector<int>(size, -1), std::vector<float>(size, 0.0F)};
  }
};

struct Point {
  float name, x, y;
};

inline nn::Features Named(const std::vector<Point>& points) {
  nn::Features features;
  features.width = 64;
  features.height = 48;
  features.keypoints.resize(static_cast<Eigen::Index>(points.size()), 2);
  features.scores.resize(static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    features.keypoints.row(static_cast<Eigen::Index>(i)) << points[i].x, points[i].y;
    features.scores[static_cast<Eigen::Index>(i)] = points[i].name;
  }
  return features;
}

}  // namespace gluevo::vo::testing
