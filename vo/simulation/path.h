#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

#include "gluevo/vo/core/rigid3.h"

namespace gluevo::simulation {

/// world_from_body at a time in seconds after the start; smooth (three times differentiable), at
/// rest before 0 but for "straight". The world's z points up. The body is EuRoC's: x up, y right, z
/// forward.
using SimulationPath = std::function<vo::Rigid3(double)>;

/// Throws Error listing the known names for an unknown one.
SimulationPath MakeSimulationPath(const std::string& name);
/// When the named path has gone so many laps, seconds after its start: it is where it was at the
/// end of the first, and at its beginning but for the speed. Throws Error for one without laps.
double LapsEnd(const std::string& name, int laps);
/// The room that suits a path: metres from the path's box.
struct RoomMargins {
  double side = 3.0;   ///< To the walls.
  double ahead = 3.0;  ///< To the wall at the end of x.
  double above = 1.6;  ///< To the ceiling.
};
/// Of the named path.
RoomMargins MarginsOf(const std::string& name);

/// What an ideal inertial unit on the path would feel.
struct Motion {
  vo::Rigid3 world_from_body;
  Eigen::Vector3d velocity_in_world;         // m/s
  Eigen::Vector3d acceleration_in_world;     // m/s^2
  Eigen::Vector3d angular_velocity_in_body;  // rad/s
  Eigen::Vector3d specific_force_in_body;    // m/s^2: acceleration minus gravity
};

/// Gravity in the simulated world, m/s^2 (along -z).
inline constexpr double kSimulationGravity = 9.81;

/// By central differences over 2 ms: the error of the acceleration is the fourth derivative's
/// 1e-6 / 12, below 1e-6 m/s^2 on the named paths and 1e-3 m/s^2 at 10 000 m/s^4, as where a hand
/// shakes the body by 5 cm at 3 Hz; the sensor's noise is 2.8e-2 a sample.
Motion MotionAt(const SimulationPath& path, double time_s);

}  // namespace gluevo::simulation
