#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/inertial/imu_readings.h"
#include "gluevo/vo/inertial/preintegration.h"

namespace gluevo::vo {

/// Whether the clocks of images and inertial unit agree: over a run the turns that images show are
/// compared with those of the gyroscope, some seconds at a time, and the time offset (ImuReadings)
/// estimated that brings them in line, by least squares beside the gyroscope's bias and what vision
/// has wrong in each frame. Of an offset of 20 ms and more the estimate is a few percent off: turns
/// are taken to first order.
class ClockWatch {
 public:
  /// The next frame as the images alone show it: not as an estimate has it in which the readings
  /// took part. Frames more than 0.5 s apart, or without readings between, tell nothing.
  void Add(const StampedPose& world_from_body, const ImuReadings& readings);
  /// The frames that come have nothing to do with those before.
  void Break();
  /// From the next frame on the readings have a say in the map that frames are located in, or no
  /// more: what they show of the clocks is then less than what there is.
  void SetHasInertia(bool has_inertia);

  struct Offset {
    double offset_s = 0.0;
    double sigma_s = 0.0;  ///< One standard deviation, by how well turns fit.
    /// Of frames in whose map the readings have a say: what there is is more than twice as much.
    bool is_part = false;
  };
  /// By the frames with a say of the readings or by those without, whichever are the surer that it
  /// is not zero; nothing where too little was seen. Readings that are stamped late have a positive
  /// one.
  std::optional<Offset> Estimate() const;
  /// A sentence where stamps are surely wrong by more than 3 ms, else empty.
  std::string Fault() const;

 private:
  struct Interval {
    std::size_t first = 0;  ///< Into frames_.
    Preintegration measured;
  };
  /// What the frames since the last ones say; nothing where they are too few.
  std::optional<Offset> Newest() const;
  void Finish();

  Trajectory frames_;
  std::vector<Interval> intervals_;
  bool has_inertia_ = false;
  std::array<std::vector<Offset>, 2> finished_;  ///< Without and with a say of the readings.
};

}  // namespace gluevo::vo
