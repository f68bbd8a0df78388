#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/median.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/doctor/doctor.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/io/imu_data.h"

// One group of findings a function. Bars stand where they are used, with what they rest on.
namespace gluevo::vo {

using Findings = std::vector<Finding>;

/// A finding by two bars: good up to the first, suspicious up to the second, else wrong.
Verdict UpTo(double value, double good, double suspicious);

/// Rate, gaps, jitter of times in order.
Findings CheckStamps(const std::vector<int64_t>& times_ns);

/// Brightness, contrast, sharpness, images that are equal. `followers` are the left images of the
/// frames after the pairs', empty where there is none.
Findings CheckImages(const std::vector<StereoFrame>& pairs, const std::vector<cv::Mat>& followers);

/// A point seen by both cameras: pixels.
struct PixelMatch {
  Eigen::Vector2d left;
  Eigen::Vector2d right;
};

/// Features of two images that belong together: ORB, mutually nearest and distinct, within the
/// images' own epipolar geometry. Empty where too few agree with one.
std::vector<PixelMatch> MatchFeatures(const cv::Mat& left, const cv::Mat& right);

/// Without a calibration: whether the right image sees things further left, and at what height.
Findings CheckPixels(const std::vector<std::vector<PixelMatch>>& matches);

/// The calibration against matches: epipolar error, offset, direction of the baseline.
Findings CheckCalibration(const StereoRig& rig,
                          const std::vector<std::vector<PixelMatch>>& matches);

/// Baseline, focal lengths and principal points by themselves.
Findings CheckRig(const StereoRig& rig);

/// The inertial unit, where there is one. `times_ns`: of the images, on the same clock; empty where
/// that is not known.
Findings CheckImu(const std::optional<ImuData>& imu, const std::vector<int64_t>& times_ns);

/// Presence, and the share of the frames that it covers.
Findings CheckGroundtruth(const std::optional<Trajectory>& groundtruth,
                          const std::vector<int64_t>& times_ns);

/// The images in the usual pairs of folders below a folder that is no data set.
struct LooseImages {
  std::array<std::vector<std::filesystem::path>, 2> files;  ///< In the order of names.
};
std::optional<LooseImages> FindLooseImages(const std::filesystem::path& root);

/// Gray, 8 bits; empty where the file cannot be decoded.
cv::Mat ReadLooseImage(const std::filesystem::path& file, int gray_bits);

}  // namespace gluevo::vo
