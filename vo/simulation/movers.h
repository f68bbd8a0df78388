#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "flight.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "world.h"

namespace gluevo::simulation {

/// A box on its way through the scene, straight on at a constant speed.
struct Mover {
  SimulatedBox box;                                             ///< Where it is at time 0.
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();  ///< m/s

  SimulatedBox At(double time_s) const;
};

/// Draws `count` movers, whose times are spread over the flight. Each comes once to a place before
/// the left camera where it fills `cover` of the image, 0.9 to 2 m away; some cross the view,
/// others are overtaken or overtake. None comes nearer to the body than 0.45 m. They pass through
/// furniture and walls, as ghosts do. Throws Error where there is no way for one.
std::vector<Mover> MakeMovers(uint64_t seed, int count, double cover, const Flight& flight,
                              const vo::StereoRig& rig, double texel_m, int threads,
                              const std::function<void()>& checkpoint = {});

/// The world at a time, with the movers as its last boxes.
SimulatedWorld WorldAt(const SimulatedWorld& world, const std::vector<Mover>& movers,
                       double time_s);

}  // namespace gluevo::simulation
