#include "flight.h"

#include <cmath>
#include <cstdio>
#include <memory>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "spline.h"

namespace gluevo::simulation {
namespace {

/// As large as real clocks', so that whatever keeps times in too few digits shows.
constexpr int64_t kStartNs = 1'500'000'000'000'000'000;

std::string Seconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f s", seconds);
  return text;
}

Flight FlyTrajectory(const SimulationOptions& options) {
  const std::string file = options.trajectory.string();
  const vo::Trajectory trajectory = vo::ReadTrajectory(options.trajectory);
  const auto spline = std::make_shared<const TrajectorySpline>(trajectory, file);
  const double start =
      options.start_s + (options.from_takeoff ? TakeOffSeconds(trajectory, file) : 0.0);
  const double rest = spline->duration_s() - start;
  if (!(rest > 0.0) || options.duration_s.value_or(0.0) > rest) {
    throw Error(file + ": ends " + Seconds(spline->duration_s()) +
                " after its first pose, expected more than the start of " + Seconds(start) +
                (options.duration_s ? " and the duration of " + Seconds(*options.duration_s) : ""));
  }
  Flight flight;
  flight.path = [spline, start](double time) { return spline->At(start + time); };
  flight.duration_s = options.duration_s.value_or(rest);
  flight.start_ns = trajectory.front().timestamp_ns + std::llround(start * 1e9);
  if (flight.start_ns < 0) {
    throw Error(file + ": begins before time 0, which the names of images cannot tell");
  }
  flight.description =
      "trajectory " + options.trajectory.filename().string() + " from " + Seconds(start) + " on";
  return flight;
}

}  // namespace

Flight PlanFlight(const SimulationOptions& options) {
  if (!options.trajectory.empty()) return FlyTrajectory(options);
  constexpr double kDefaultS = 20.0;
  const double start = options.start_s;
  Flight flight;
  flight.path = [path = MakeSimulationPath(options.path), start](double time) {
    return path(start + time);
  };
  flight.duration_s = options.laps > 0 ? LapsEnd(options.path, options.laps)
                                       : options.duration_s.value_or(kDefaultS);
  flight.start_ns = kStartNs + std::llround(start * 1e9);
  flight.margins = MarginsOf(options.path);
  flight.description = "path " + options.path;
  return flight;
}

std::vector<Eigen::Vector3d> FlightPoints(const Flight& flight) {
  constexpr double kStepS = 0.1;
  const int steps = static_cast<int>(std::ceil(flight.duration_s / kStepS));
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= steps; ++i) {
    points.push_back(flight.path(flight.duration_s * i / steps).translation);
  }
  return points;
}

}  // namespace gluevo::simulation
