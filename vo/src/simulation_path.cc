#include "simulation_path.h"

#include <cmath>
#include <numbers>

#include "gluevo/nn/error.h"
#include "gluevo/vo/simulation.h"

namespace gluevo::vo {
namespace {

constexpr double kPi = std::numbers::pi;

/// Time that has a smooth start: 0 until 0, then faster, and of unit rate from `ramp_s` on, half a
/// ramp behind. The rate rises as x - sin(2 pi x) / (2 pi), whose first two derivatives vanish at
/// both ends.
double EasedTime(double time_s, double ramp_s) {
  if (time_s <= 0.0) return 0.0;
  if (time_s >= ramp_s) return time_s - 0.5 * ramp_s;
  const double x = time_s / ramp_s;
  const double integral = 0.5 * x * x + (std::cos(2.0 * kPi * x) - 1.0) / (4.0 * kPi * kPi);
  return ramp_s * integral;
}

/// The body that looks along `forward` with its head turned by `roll` (to the right, radians).
Eigen::Quaterniond LookAlong(const Eigen::Vector3d& forward, double roll) {
  const Eigen::Vector3d z = forward.normalized();
  const Eigen::Vector3d y = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d world_from_body;
  world_from_body << y.cross(z), y, z;
  return Eigen::Quaterniond(world_from_body) *
         Eigen::Quaterniond(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()));
}

/// One lap of an oval in 20 s, eyes along the path and wandering a little; laps repeat exactly.
Rigid3 HallLoop(double time_s) {
  constexpr double kLapS = 20.0;
  constexpr double kRampS = 2.0;
  constexpr double kHalfLength = 3.4;
  constexpr double kHalfWidth = 2.2;
  const double phase = 2.0 * kPi * EasedTime(time_s, kRampS) / (kLapS - 0.5 * kRampS);
  const double tangent = std::atan2(kHalfWidth * std::cos(phase), -kHalfLength * std::sin(phase));
  const double yaw = tangent + 0.2 * std::sin(2.0 * phase);
  const double pitch = 0.08 * std::sin(3.0 * phase);
  const double roll = 0.06 * std::sin(2.0 * phase + 0.7);
  const Eigen::Vector3d forward(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch),
                                std::sin(pitch));
  const Eigen::Vector3d position(kHalfLength * std::cos(phase), kHalfWidth * std::sin(phase),
                                 1.5 + 0.25 * std::sin(2.0 * phase));
  return {LookAlong(forward, roll), position};
}

}  // namespace

std::vector<std::string> SimulationPaths() { return {"hall_loop"}; }

SimulationPath MakeSimulationPath(const std::string& name) {
  if (name == "hall_loop") return HallLoop;
  std::string known;
  for (const std::string& path : SimulationPaths()) known += (known.empty() ? "" : ", ") + path;
  throw Error("unknown path \"" + name + "\" to simulate, expected one of: " + known);
}

Motion MotionAt(const SimulationPath& path, double time_s) {
  constexpr double kStepS = 1e-3;
  const Rigid3 before = path(time_s - kStepS);
  const Rigid3 now = path(time_s);
  const Rigid3 after = path(time_s + kStepS);
  Motion motion;
  motion.world_from_body = now;
  motion.velocity_in_world = (after.translation - before.translation) / (2.0 * kStepS);
  motion.acceleration_in_world =
      (after.translation - 2.0 * now.translation + before.translation) / (kStepS * kStepS);
  const Eigen::AngleAxisd turn(before.rotation.conjugate() * after.rotation);
  motion.angular_velocity_in_body = turn.axis() * turn.angle() / (2.0 * kStepS);
  motion.specific_force_in_body =
      now.rotation.conjugate() *
      (motion.acceleration_in_world + kSimulationGravity * Eigen::Vector3d::UnitZ());
  return motion;
}

}  // namespace gluevo::vo
