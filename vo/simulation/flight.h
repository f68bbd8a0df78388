#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gluevo/vo/simulation/simulation.h"
#include "path.h"

namespace gluevo::simulation {

/// What a simulation flies.
struct Flight {
  SimulationPath path;  ///< Time from 0, the first image's.
  double duration_s = 0.0;
  int64_t start_ns = 0;     ///< The data set's clock at time 0.
  RoomMargins margins;      ///< Of its room.
  std::string description;  ///< For comments in files.
};

/// The named path, or the trajectory from the start on. Throws Error for an unknown name, for a
/// file that cannot be read or flown, and for a start or duration beyond its end.
Flight PlanFlight(const SimulationOptions& options);

/// Positions of the body every 0.1 s or less, metres.
std::vector<Eigen::Vector3d> FlightPoints(const Flight& flight);

}  // namespace gluevo::simulation
