#include "gluevo/vo/inertial/initialisation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/inertial/gravity.h"
#include "gyroscope_start.h"
#include "motion_equations.h"

namespace gluevo::vo {
namespace {

/// The samples from the first frame to the last, and one beyond each; some more where it is not
/// known how their clock goes.
std::vector<ImuSample> Around(const Trajectory& frames, const std::vector<ImuSample>& samples,
                              double time_offset_sigma_s) {
  if (frames.empty() || samples.empty()) {
    return {};
  }
  const auto at = [&](int64_t time_ns) {
    return std::lower_bound(
        samples.begin(), samples.end(), time_ns,
        [](const ImuSample& sample, int64_t time) { return sample.timestamp_ns < time; });
  };
  constexpr double kSigmas = 10.0;
  const int64_t margin_ns = std::llround(1e9 * kSigmas * time_offset_sigma_s);
  const auto begin = at(frames.front().timestamp_ns - margin_ns);
  const auto end = at(frames.back().timestamp_ns + margin_ns);
  return {begin == samples.begin() ? begin : begin - 1, end == samples.end() ? end : end + 1};
}

/// Takes a further time offset into account.
void MoveBy(double time_offset_s, std::vector<ImuSample>& samples) {
  for (ImuSample& sample : samples) {
    sample.timestamp_ns -= std::llround(1e9 * time_offset_s);
  }
}

void SolveForMotion(const EliminatedFrames& frames, double length, InertialStart& start) {
  const FreeEquations& free = frames.equations;
  FreeEquations::State state = free.hessian.ldlt().solve(free.gradient);
  start.free_gravity = state.tail<3>().norm();
  Eigen::Vector3d gravity = length * state.tail<3>().normalized();
  constexpr int kTimes = 2;
  for (int i = 0; i < kTimes; ++i) {
    const SphereEquations sphere = OnSphere(free, gravity);
    const SphereEquations::State on_sphere = sphere.hessian.ldlt().solve(sphere.gradient);
    gravity = TurnedGravity(gravity, on_sphere.tail<2>());
    state << on_sphere.head<6>(), gravity;
    start.motion_rms = Rms(sphere.Sum(on_sphere), sphere.freedom);
    start.covariance = sphere.hessian.inverse();
  }
  // Where residuals are larger than they should be, so is all that follows from them.
  const double scale = std::max(1.0, start.motion_rms);
  start.covariance *= scale * scale;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> turns(
      start.covariance.bottomRightCorner<2, 2>());
  start.gravity_sigma = std::sqrt(std::max(0.0, turns.eigenvalues().maxCoeff()));
  start.gravity_in_world = gravity;
  start.bias.gyroscope += state.head<3>();
  start.bias.accelerometer += state.segment<3>(3);
  start.velocities_in_world = frames.Velocities(state);
}

std::string Degrees(double radians) { return ShortText(radians / kDegree, 3) + " degrees"; }

std::string WhyRefused(const InertialStart& start, const InitialisationOptions& options) {
  const auto disagree = [](const std::string& sensor, double rms) {
    return "the " + sensor + " and the images disagree, by " + ShortText(rms, 3) +
           " standard deviations: is the unit mounted as the calibration says, and its clock that "
           "of the images?";
  };
  if (!(start.rotation_rms <= options.largest_rms)) {
    return disagree("gyroscope", start.rotation_rms);
  }
  if (!(start.motion_rms <= options.largest_rms)) {
    return disagree("accelerometer", start.motion_rms);
  }
  if (!(std::abs(start.free_gravity - options.gravity) <=
        options.largest_gravity_error * options.gravity)) {
    return "gravity comes out as " + ShortText(start.free_gravity, 4) + " m/s^2, expected " +
           ShortText(options.gravity, 4);
  }
  if (!(start.gravity_sigma <= options.largest_gravity_sigma)) {
    return "gravity's direction is known to " + Degrees(start.gravity_sigma) + " only, expected " +
           Degrees(options.largest_gravity_sigma) + ": the body has to turn";
  }
  return "";
}

}  // namespace

void InitialisationOptions::Validate() const {
  CheckPositive(gravity, "gravity");
  CheckPositive(vision_position_sigma, "vision_position_sigma");
  CheckPositive(vision_rotation_sigma, "vision_rotation_sigma");
  CheckPositive(gyroscope_bias_sigma, "gyroscope_bias_sigma");
  CheckPositive(accelerometer_bias_sigma, "accelerometer_bias_sigma");
  CheckWithin(time_offset_sigma_s, 0.0, 1.0, "time_offset_sigma_s");
  CheckPositive(least_duration_s, "least_duration_s");
  CheckPositive(largest_gravity_sigma, "largest_gravity_sigma");
  CheckPositive(largest_gravity_error, "largest_gravity_error");
  CheckPositive(largest_rms, "largest_rms");
}

InertialStart StartInMotion(const Trajectory& frames, const std::vector<ImuSample>& all_samples,
                            const ImuNoise& noise, const InitialisationOptions& options) {
  options.Validate();
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (frames[i].timestamp_ns <= frames[i - 1].timestamp_ns) {
      throw Error("initialisation: frames that are not in order of time");
    }
  }
  std::vector<ImuSample> samples = Around(frames, all_samples, options.time_offset_sigma_s);
  InertialStart start;
  std::vector<FrameInterval> intervals = IntegrateIntervals(frames, samples, start.bias, noise);
  double duration_s = 0.0;
  for (const FrameInterval& interval : intervals) {
    duration_s += interval.measured.duration_s;
  }
  // With fewer residuals fit by chance: of seconds apart some were that were wrong.
  constexpr std::size_t kFewest = 10;
  if (intervals.size() < kFewest || duration_s < options.least_duration_s) {
    start.refused = "too few of the newest frames have readings from one to the next, expected " +
                    std::to_string(kFewest + 1) + " such frames or more, over " +
                    ShortText(options.least_duration_s) + " s";
    return start;
  }
  GyroscopeStart gyroscope;
  // Again where the bias is what it is: far from it, derivatives are not those at zero.
  constexpr int kTimes = 2;
  constexpr int kTimesWithOffset = 6;
  const int times = options.time_offset_sigma_s > 0.0 ? kTimesWithOffset : kTimes;
  for (int i = 0; i < times; ++i) {
    gyroscope = EstimateGyroscopeBias(frames, intervals, options, start.time_offset_s);
    MoveBy(gyroscope.time_offset_s, samples);
    start.time_offset_s += gyroscope.time_offset_s;
    start.bias.gyroscope += gyroscope.bias;
    intervals = IntegrateIntervals(frames, samples, start.bias, noise);
  }
  start.rotation_rms = gyroscope.rms;
  start.time_offset_sigma_s = gyroscope.time_offset_sigma_s * std::max(1.0, gyroscope.rms);
  SolveForMotion(BuildMotionEquations(frames, intervals, gyroscope.covariance, options),
                 options.gravity, start);
  start.refused = WhyRefused(start, options);
  return start;
}

}  // namespace gluevo::vo
