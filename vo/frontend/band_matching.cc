#include "band_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

// Of unit vectors, from their cosine.
double DistanceOf(float cosine) { return std::sqrt(std::max(0.0, 2.0 - 2.0 * cosine)); }

}  // namespace

std::vector<Eigen::Vector2d> RaysOf(const nn::Features& features, const Camera& camera) {
  std::vector<Eigen::Vector2d> rays;
  rays.reserve(static_cast<std::size_t>(features.size()));
  for (int i = 0; i < features.size(); ++i) {
    rays.push_back(camera.Undistort(features.keypoints.row(i).transpose().cast<double>()));
  }
  return rays;
}

nn::Matches MatchInBand(const nn::Features& left, const std::vector<Eigen::Vector2d>& left_rays,
                        const nn::Features& right, const std::vector<Eigen::Vector2d>& right_rays,
                        const EpipolarCheck& epipolar, double max_error_px, double max_ratio) {
  const auto count = static_cast<std::size_t>(left.size());
  nn::Matches matches{std::vector<int>(count, -1), std::vector<float>(count, 0.0F)};
  if (left.size() == 0 || right.size() == 0) {
    return matches;
  }
  if (left.descriptors.cols() != right.descriptors.cols()) {
    throw Error("descriptors of " + std::to_string(left.descriptors.cols()) + " and of " +
                std::to_string(right.descriptors.cols()) + " values cannot be matched");
  }
  constexpr float kNone = -std::numeric_limits<float>::infinity();
  nn::Features::RowMajor similarity = left.descriptors * right.descriptors.transpose();
  for (int i = 0; i < left.size(); ++i) {
    for (int j = 0; j < right.size(); ++j) {
      const bool is_candidate = epipolar.Allows(left_rays[i], right_rays[j], max_error_px);
      similarity(i, j) = is_candidate ? similarity(i, j) : kNone;
    }
  }
  for (int i = 0; i < left.size(); ++i) {
    Eigen::Index nearest = 0;
    const float cosine = similarity.row(i).maxCoeff(&nearest);
    Eigen::Index mutual = 0;
    similarity.col(nearest).maxCoeff(&mutual);
    if (cosine == kNone || mutual != i) {
      continue;
    }
    similarity(i, nearest) = kNone;
    const float second = similarity.row(i).maxCoeff();
    similarity(i, nearest) = cosine;
    if (second == kNone || max_ratio >= 1.0 ||
        DistanceOf(cosine) < max_ratio * DistanceOf(second)) {
      matches.matches0[i] = static_cast<int>(nearest);
      matches.scores0[i] = std::clamp(cosine, 0.0F, 1.0F);
    }
  }
  return matches;
}

}  // namespace gluevo::vo
