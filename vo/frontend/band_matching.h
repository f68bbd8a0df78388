#pragma once

#include <Eigen/Core>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/vo/geometry/camera.h"
#include "gluevo/vo/geometry/epipolar.h"

namespace gluevo::vo {

/// The features' points on the camera's normalised plane, NaN for those beyond its model.
std::vector<Eigen::Vector2d> RaysOf(const nn::Features& features, const Camera& camera);

/// Nearest neighbours by descriptor from left to right, among the right keypoints that the epipolar
/// geometry allows: at most `max_error_px` from the line, and in front of both cameras. A match is
/// each other's nearest and closer than `max_ratio` times the second nearest candidate; its
/// confidence is the cosine, clamped to 0 to 1. `left_rays` and `right_rays`: the features' points
/// on the normalised planes, NaN for those without.
nn::Matches MatchInBand(const nn::Features& left, const std::vector<Eigen::Vector2d>& left_rays,
                        const nn::Features& right, const std::vector<Eigen::Vector2d>& right_rays,
                        const EpipolarCheck& epipolar, double max_error_px, double max_ratio);

}  // namespace gluevo::vo
