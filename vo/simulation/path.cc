#include "path.h"

#include <array>
#include <cmath>
#include <numbers>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/vo/simulation/simulation.h"

namespace gluevo::simulation {
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
vo::Rigid3 HallLoop(double time_s) {
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

/// A step from 0 to 1 over one unit of time, its first two derivatives 0 at both ends.
double Step(double x) {
  if (x <= 0.0 || x >= 1.0) return x <= 0.0 ? 0.0 : 1.0;
  return x - std::sin(2.0 * kPi * x) / (2.0 * kPi);
}

Eigen::Vector3d Direction(double yaw, double pitch) {
  return {std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch)};
}

/// A lying eight (Gerono's lemniscate) in 20 s, eyes along the path: turns both ways.
vo::Rigid3 FigureEight(double time_s) {
  constexpr double kLapS = 20.0;
  constexpr double kRampS = 2.0;
  const double phase = 2.0 * kPi * EasedTime(time_s, kRampS) / (kLapS - 0.5 * kRampS);
  const double yaw = std::atan2(3.6 * std::cos(2.0 * phase), -3.2 * std::sin(phase));
  const Eigen::Vector3d position(3.2 * std::cos(phase), 1.8 * std::sin(2.0 * phase),
                                 1.4 + 0.2 * std::sin(3.0 * phase));
  return {LookAlong(Direction(yaw, 0.06 * std::sin(2.0 * phase)), 0.05 * std::sin(phase)),
          position};
}

/// Down a corridor of 12 m and back in 20 s, turning round at its ends.
vo::Rigid3 Corridor(double time_s) {
  constexpr double kLapS = 20.0;
  constexpr double kTurnS = 4.0;
  const double time = EasedTime(time_s, 2.0);
  const double phase = 2.0 * kPi * time / kLapS;
  // Half turns, centred on the ends; always to the left, so that the head goes full circle.
  double turns = 0.0;
  for (double end = 0.5 * kLapS; end < time + kTurnS; end += 0.5 * kLapS) {
    turns += Step((time - end) / kTurnS + 0.5);
  }
  const double yaw = kPi * turns + 0.1 * std::sin(1.3 * time);
  const Eigen::Vector3d position(-6.0 * std::cos(phase), 0.15 * std::sin(5.0 * phase),
                                 1.4 + 0.1 * std::sin(3.0 * phase));
  return {LookAlong(Direction(yaw, 0.04 * std::sin(0.9 * time)), 0.04 * std::sin(1.1 * time)),
          position};
}

/// In one place as well as a flying body can: some centimetres and degrees to and fro.
vo::Rigid3 Hover(double time_s) {
  const double time = EasedTime(time_s, 2.0);
  const auto sway = [time](double size, double period_s) {
    return size * (std::sin(2.0 * kPi * time / period_s) +
                   0.4 * std::sin(2.0 * kPi * 2.7 * time / period_s));
  };
  return {LookAlong(Direction(sway(0.05, 6.1), sway(0.02, 4.3)), sway(0.02, 5.2)),
          Eigen::Vector3d(sway(0.06, 5.0), sway(0.06, 6.7), 1.4 + sway(0.03, 4.1))};
}

/// Turning on the spot at 0.7 to 2.5 radians a second.
vo::Rigid3 FastYaw(double time_s) {
  const double time = EasedTime(time_s, 2.0);
  const double yaw = 1.6 * time + 0.6 * std::sin(1.5 * time);
  const Eigen::Vector3d position(0.3 * std::cos(0.5 * time), 0.3 * std::sin(0.5 * time),
                                 1.5 + 0.1 * std::sin(0.8 * time));
  return {LookAlong(Direction(yaw, 0.05 * std::sin(1.1 * time)), 0.05 * std::sin(0.7 * time)),
          position};
}

// What does not move all an inertial unit needs: such motions must do no harm.

vo::Rigid3 Rest(double /*time_s*/) {
  return {LookAlong(Direction(0.3, 0.05), 0.04), {0.0, 0.0, 1.4}};
}

/// Straight on at half a metre a second, before 0, too: nothing turns, nothing gets faster.
vo::Rigid3 Straight(double time_s) {
  constexpr double kSpeed = 0.5;
  return {LookAlong(Direction(0.1, 0.03), 0.02), {kSpeed * time_s, 0.0, 1.4}};
}

/// Turning about the body's own place, at 0.2 to 0.8 radians a second about the vertical.
vo::Rigid3 Spin(double time_s) {
  const double time = EasedTime(time_s, 2.0);
  const double yaw = 0.5 * time + 0.3 * std::sin(time);
  return {LookAlong(Direction(yaw, 0.1 * std::sin(0.7 * time)), 0.0), {0.0, 0.0, 1.5}};
}

/// A car's: level, in a plane, turning about the vertical alone.
vo::Rigid3 Planar(double time_s) {
  constexpr double kLapS = 20.0;
  constexpr double kRampS = 2.0;
  const double phase = 2.0 * kPi * EasedTime(time_s, kRampS) / (kLapS - 0.5 * kRampS);
  const double yaw = std::atan2(2.2 * std::cos(phase), -3.4 * std::sin(phase));
  return {LookAlong(Direction(yaw, 0.0), 0.0), {3.4 * std::cos(phase), 2.2 * std::sin(phase), 1.2}};
}

/// A car's down a street, at 7 to 9 m/s: from one side to the other and back in 60 m.
vo::Rigid3 Street(double time_s) {
  constexpr double kSpeed = 8.0;
  constexpr double kWavelength = 60.0;
  constexpr double kSide = 1.5;
  const double time = EasedTime(time_s, 3.0);
  const double x = kSpeed * time + 1.5 * std::sin(0.6 * time);
  const double phase = 2.0 * kPi * x / kWavelength;
  const double yaw = std::atan(kSide * 2.0 * kPi / kWavelength * std::cos(phase));
  const double pitch = 0.004 * std::sin(2.1 * time);
  return {LookAlong(Direction(yaw, pitch), 0.004 * std::sin(1.7 * time)),
          {x, kSide * std::sin(phase), 1.5 + 0.01 * std::sin(2.1 * time)}};
}

struct NamedPath {
  const char* name;
  vo::Rigid3 (*path)(double);
  RoomMargins margins;
  double lap_s;        ///< Of all laps but the first; 0: it has none.
  double first_lap_s;  ///< From rest.
};

constexpr std::array kNamedPaths = {NamedPath{"hall_loop", HallLoop, {2.6, 2.6}, 19.0, 20.0},
                                    NamedPath{"figure_eight", FigureEight, {2.6, 2.6}, 19.0, 20.0},
                                    NamedPath{"corridor", Corridor, {1.3, 1.3}, 20.0, 21.0},
                                    NamedPath{"hover", Hover, {3.0, 3.0}, 0.0, 0.0},
                                    NamedPath{"fast_yaw", FastYaw, {3.0, 3.0}, 0.0, 0.0},
                                    NamedPath{"rest", Rest, {3.0, 3.0}, 0.0, 0.0},
                                    NamedPath{"straight", Straight, {3.0, 3.0}, 0.0, 0.0},
                                    NamedPath{"spin", Spin, {3.0, 3.0}, 0.0, 0.0},
                                    NamedPath{"planar", Planar, {2.6, 2.6}, 19.0, 20.0},
                                    NamedPath{"street", Street, {8.0, 200.0, 10.0}, 0.0, 0.0}};

const NamedPath& Find(const std::string& name) {
  std::string known;
  for (const NamedPath& path : kNamedPaths) {
    if (name == path.name) return path;
    known += std::string(known.empty() ? "" : ", ") + path.name;
  }
  throw Error("unknown path \"" + name + "\" to simulate, expected one of: " + known);
}

}  // namespace

std::vector<std::string> SimulationPaths() {
  std::vector<std::string> names;
  names.reserve(kNamedPaths.size());
  for (const NamedPath& path : kNamedPaths) names.emplace_back(path.name);
  return names;
}

SimulationPath MakeSimulationPath(const std::string& name) { return Find(name).path; }

double LapsEnd(const std::string& name, int laps) {
  const NamedPath& path = Find(name);
  if (path.lap_s == 0.0) {
    throw OptionError("the path \"" + name +
                      "\" has no laps to count (--laps), expected a duration");
  }
  return path.first_lap_s + (laps - 1) * path.lap_s;
}

RoomMargins MarginsOf(const std::string& name) { return Find(name).margins; }

Motion MotionAt(const SimulationPath& path, double time_s) {
  constexpr double kStepS = 1e-3;
  const vo::Rigid3 before = path(time_s - kStepS);
  const vo::Rigid3 now = path(time_s);
  const vo::Rigid3 after = path(time_s + kStepS);
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

}  // namespace gluevo::simulation
