#include <algorithm>
#include <cmath>

#include "checks.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

/// Points of a match on the planes z = 1.
struct RayMatch {
  Eigen::Vector2d left;
  Eigen::Vector2d right;
};

/// How one supposition about the rig fits the matches.
struct Fit {
  double error_px = 0.0;     ///< Median distance from the epipolar line, right camera's pixels.
  double offset_px = 0.0;    ///< The same with its sign: how much lower points are than expected.
  double in_front = 0.0;     ///< Share of the matches that meet in front of the cameras.
  double inverse_depth = 0;  ///< Median, 1/metres.
};

/// What the images would be if the files or the transform were mistaken.
enum class Supposition { kAsSaid, kImagesExchanged, kTransformInverted };

std::vector<RayMatch> Rays(const StereoRig& rig,
                           const std::vector<std::vector<PixelMatch>>& matches, bool exchanged) {
  std::vector<RayMatch> rays;
  for (const std::vector<PixelMatch>& pair : matches) {
    for (const PixelMatch& match : pair) {
      const RayMatch ray = {rig.cameras[0].Undistort(exchanged ? match.right : match.left),
                            rig.cameras[1].Undistort(exchanged ? match.left : match.right)};
      if (ray.left.allFinite() && ray.right.allFinite()) {
        rays.push_back(ray);
      }
    }
  }
  return rays;
}

Fit FitOf(const Rigid3& right_from_left, double focal_px, const std::vector<RayMatch>& rays) {
  const Eigen::Matrix3d rotation = right_from_left.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = right_from_left.translation;
  const Eigen::Matrix3d essential = Skew(t) * rotation;
  std::vector<double> distances;
  std::vector<double> offsets;
  std::vector<double> inverse_depths;
  double in_front = 0.0;
  for (const RayMatch& ray : rays) {
    Eigen::Vector3d line = essential * ray.left.homogeneous();
    line *= line.y() < 0.0 ? -1.0 : 1.0;  // Downwards.
    const double offset = focal_px * line.dot(ray.right.homogeneous()) / line.head<2>().norm();
    distances.push_back(std::abs(offset));
    offsets.push_back(offset);
    // Least squares of right x (R left + t w) = 0 for the inverse depth w along the left ray.
    const Eigen::Vector3d a = ray.right.homogeneous().cross(t);
    const Eigen::Vector3d b = ray.right.homogeneous().cross(rotation * ray.left.homogeneous());
    const double inverse_depth = -a.dot(b) / a.squaredNorm();
    inverse_depths.push_back(inverse_depth);
    // A point at infinity may be a pixel behind it.
    const double tolerance = 1.0 / (focal_px * t.norm());
    in_front += inverse_depth >= -tolerance ? 1.0 : 0.0;
  }
  return {Median(distances), Median(offsets),
          rays.empty() ? 0.0 : in_front / static_cast<double>(rays.size()), Median(inverse_depths)};
}

Fit FitOf(const StereoRig& rig, const std::vector<std::vector<PixelMatch>>& matches,
          Supposition supposition) {
  const Rigid3 right_from_left = rig.right_from_left();
  return FitOf(
      supposition == Supposition::kTransformInverted ? right_from_left.Inverse() : right_from_left,
      0.5 * (rig.cameras[1].fx + rig.cameras[1].fy),
      Rays(rig, matches, supposition == Supposition::kImagesExchanged));
}

// ORB's points are good to half a pixel; a calibration of a rig that has been knocked about is off
// by a pixel or two, one of another rig or another unit by many.
constexpr double kGoodError = 1.0;
constexpr double kBadError = 3.0;
// Some false matches lie on the right side of infinity, and some true ones of it on the wrong.
constexpr double kMostInFront = 0.8;
constexpr double kFewInFront = 0.5;

bool IsGood(const Fit& fit) { return fit.in_front >= kMostInFront && fit.error_px <= kGoodError; }

std::string Described(const Fit& fit) {
  return FixedText(fit.error_px, 2) + " px and " + FixedText(100.0 * fit.in_front, 0) +
         " % in front";
}

/// A finding where the calibration does not fit and one simple mistake would explain it.
Findings ExplainMisfit(const StereoRig& rig, const std::vector<std::vector<PixelMatch>>& matches,
                       const Fit& fit) {
  if (IsGood(fit)) {
    return {};
  }
  const Fit exchanged = FitOf(rig, matches, Supposition::kImagesExchanged);
  const Fit inverted = FitOf(rig, matches, Supposition::kTransformInverted);
  bool is_exchanged = IsGood(exchanged);
  if (is_exchanged && IsGood(inverted)) {
    // Both mend it, as for two cameras that are alike: what is seen by the right camera is further
    // left, in whichever image that is.
    std::vector<double> shifts;
    for (const RayMatch& ray : Rays(rig, matches, false)) {
      shifts.push_back(ray.left.x() - ray.right.x());
    }
    is_exchanged = Median(shifts) < 0.0;
  }
  if (is_exchanged) {
    return {{Verdict::kWrong, "order of the images", Described(fit),
             "left and right images are exchanged, with which it is " + Described(exchanged)}};
  }
  if (IsGood(inverted)) {
    return {
        {Verdict::kWrong, "direction of the transform", Described(fit),
         "the transform between the cameras is inverted, with which it is " + Described(inverted)}};
  }
  return {};
}

Finding CheckDepth(const Fit& fit) {
  Finding finding = {fit.in_front >= kMostInFront  ? Verdict::kGood
                     : fit.in_front >= kFewInFront ? Verdict::kSuspicious
                                                   : Verdict::kWrong,
                     "depth of matches",
                     FixedText(100.0 * fit.in_front, 0) + " % in front of the cameras",
                     "at least 80 %"};
  if (fit.inverse_depth > 0.0) {
    finding.value += ", median " + FixedText(1.0 / fit.inverse_depth, 2) + " m away";
  }
  return finding;
}

}  // namespace

Findings CheckCalibration(const StereoRig& rig,
                          const std::vector<std::vector<PixelMatch>>& matches) {
  const Fit fit = FitOf(rig, matches, Supposition::kAsSaid);
  Findings findings;
  findings.push_back({UpTo(fit.error_px, kGoodError, kBadError), "epipolar error",
                      FixedText(fit.error_px, 2) + " px (median)",
                      "up to 1 px: does the calibration belong to these images?"});
  findings.push_back({UpTo(std::abs(fit.offset_px), kGoodError, kBadError), "vertical offset",
                      FixedText(fit.offset_px, 2) + " px (median)",
                      "up to 1 px either way: are both images of one moment?"});
  findings.push_back(CheckDepth(fit));
  const Findings explanations = ExplainMisfit(rig, matches, fit);
  findings.insert(findings.end(), explanations.begin(), explanations.end());
  return findings;
}

Findings CheckPixels(const std::vector<std::vector<PixelMatch>>& matches) {
  std::vector<double> shifts;
  std::vector<double> offsets;
  for (const std::vector<PixelMatch>& pair : matches) {
    for (const PixelMatch& match : pair) {
      shifts.push_back(match.left.x() - match.right.x());
      offsets.push_back(match.right.y() - match.left.y());
    }
  }
  const double shift = Median(shifts);
  return {{shift >= 0.0 ? Verdict::kGood : Verdict::kSuspicious, "disparity",
           FixedText(shift, 1) + " px (median)",
           "above 0: things are further left in the right image; else left and right may be "
           "exchanged"},
          {Verdict::kGood, "vertical offset", FixedText(Median(offsets), 1) + " px (median)", ""}};
}

Findings CheckRig(const StereoRig& rig) {
  // Cameras of phones and cars are 2 cm to 1 m apart; ten metres are millimetres taken for metres.
  constexpr double kShort = 0.01;
  constexpr double kLong = 2.0;
  constexpr double kTooLong = 10.0;
  constexpr double kTooShort = 0.001;
  const double baseline = rig.baseline();
  Findings findings;
  Finding finding = {Verdict::kGood, "baseline", FixedText(baseline, 3) + " m", "0.01 to 2 m"};
  if (baseline > kLong || baseline < kShort) {
    finding.verdict =
        baseline > kTooLong || baseline < kTooShort ? Verdict::kWrong : Verdict::kSuspicious;
    finding.expected += ": is the translation in metres?";
  }
  findings.push_back(finding);
  const Rigid3 right_from_left = rig.right_from_left();
  const Eigen::Vector3d centre = right_from_left.Inverse().translation;
  const bool is_right = centre.x() > 0.7 * centre.norm();
  findings.push_back(
      {is_right ? Verdict::kGood : Verdict::kSuspicious, "right camera",
       "at (" + FixedText(centre.x(), 3) + ", " + FixedText(centre.y(), 3) + ", " +
           FixedText(centre.z(), 3) + ") m of the left one",
       "to the right (x): is the transform inverted, or are the cameras exchanged?"});
  constexpr const char* kSides[] = {"left camera", "right camera"};
  for (std::size_t side = 0; side < 2; ++side) {
    const Camera& camera = rig.cameras[side];
    // Fields of view of 20 to 170 degrees, a principal point within the middle half.
    const double focal = 0.5 * (camera.fx + camera.fy);
    const bool focal_fits = focal > 0.1 * camera.width && focal < 3.0 * camera.width &&
                            std::abs(camera.fx / camera.fy - 1.0) < 0.1;
    const bool centre_fits = std::abs(camera.cx / camera.width - 0.5) < 0.25 &&
                             std::abs(camera.cy / camera.height - 0.5) < 0.25;
    findings.push_back({focal_fits && centre_fits ? Verdict::kGood : Verdict::kSuspicious,
                        kSides[side],
                        std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                            ", focal length " + FixedText(focal, 1) + ", centre " +
                            FixedText(camera.cx, 1) + " " + FixedText(camera.cy, 1) + " px",
                        "pixels alike in x and y, the centre in the middle half: is it the "
                        "calibration of another image size?"});
  }
  return findings;
}

}  // namespace gluevo::vo
