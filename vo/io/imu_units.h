#pragma once

#include "gluevo/vo/io/imu_data.h"

namespace gluevo::vo {

/// Multiples of g become m/s^2, where gravity tells; milli-g, too. Refused where gravity is not in
/// the forces (taken away by the driver), or where they are zero. A body that is carried feels
/// gravity: the median of the forces' lengths is within a fifth of it but for seconds of a
/// rollercoaster.
void FitUnitOfForces(ImuData& data);

/// Degrees a second become rad/s where the sensor cannot have measured so many radians: where more
/// than a hundredth of the samples is beyond 2000 degrees a second, the range of the fastest. Slow
/// turns in degrees a second look like fast ones in radians: vision tells them apart
/// (gyroscope_check.h).
void FitUnitOfRates(ImuData& data);

}  // namespace gluevo::vo
