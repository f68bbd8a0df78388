#include "pnp_scoring.h"

#include "gluevo/vo/geometry/projection.h"

namespace gluevo::vo {
namespace {

// 99 % quantiles of the chi-square distribution with 2 and with 4 degrees of freedom.
constexpr double kGateLeft = 9.21;
constexpr double kGateBoth = 13.28;
struct Judgement {
  PnpVerdict verdict = PnpVerdict::kOutlier;
  double score = 0.0;  // 0 for an outlier, larger the better it fits
};

Judgement Judge(const PosedRig& rig, const PnpObservation& observation, double weight) {
  ViewResidual left;
  if (!Residual(rig.left, observation.point, observation.left, weight, left)) {
    return {};
  }
  const double r_r = left.error.squaredNorm();
  const double r_u = left.error.dot(left.by_depth);
  const double u_u = left.by_depth.squaredNorm();
  const double chi2_left = Mahalanobis(r_r, r_u, u_u);
  if (!(chi2_left < kGateLeft)) {
    return {};
  }
  ViewResidual right;
  if (observation.has_right &&
      Residual(rig.right, observation.point, observation.right, weight, right)) {
    const double chi2 =
        Mahalanobis(r_r + right.error.squaredNorm(), r_u + right.error.dot(right.by_depth),
                    u_u + right.by_depth.squaredNorm());
    if (chi2 < kGateBoth) {
      return {PnpVerdict::kInlier, kGateBoth - chi2};
    }
    // A wrong right observation takes most of the point's credit.
    return {PnpVerdict::kInlierLeft, 0.25 * (kGateLeft - chi2_left)};
  }
  return {observation.has_right ? PnpVerdict::kInlierLeft : PnpVerdict::kInlier,
          kGateLeft - chi2_left};
}

}  // namespace

bool Residual(const PosedCamera& camera, const AnchoredPoint& point,
              const Eigen::Vector2d& observed, double weight, ViewResidual& result) {
  const Eigen::Vector3d offset =
      camera.cam_from_world_rotation * (point.center - camera.center_in_world);
  const Eigen::Vector3d in_cam =
      camera.cam_from_world_rotation * point.ray + point.inverse_depth * offset;
  if (!IsInFront(in_cam)) {
    return false;
  }
  const double inverse_z = 1.0 / in_cam.z();
  const Eigen::Vector2d projected = in_cam.head<2>() * inverse_z;
  result.error = weight * (projected - observed);
  result.by_depth = (weight * point.inverse_depth_sigma * inverse_z) *
                    (offset.head<2>() - projected * offset.z());
  return true;
}

Hypothesis Score(const StereoRig& rig, const Rigid3& world_from_body,
                 std::span<const PnpObservation> observations, double weight) {
  const PosedRig posed(rig, world_from_body);
  Hypothesis hypothesis{world_from_body, std::vector<PnpVerdict>(observations.size())};
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Judgement judgement = Judge(posed, observations[i], weight);
    hypothesis.verdicts[i] = judgement.verdict;
    const bool is_inlier = judgement.verdict != PnpVerdict::kOutlier;
    hypothesis.inliers += is_inlier ? 1 : 0;
    hypothesis.votes += is_inlier ? observations[i].vote : 0.0;
    hypothesis.score += observations[i].vote * judgement.score;
  }
  return hypothesis;
}

}  // namespace gluevo::vo
