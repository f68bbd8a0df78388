#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gluevo/vo/io/imu_data.h"

// What goes wrong between a sensor and a file, and what is done about it. Each function adds a
// sentence to the data's warnings, or makes it `refused`.
namespace gluevo::vo {

/// Below this, what happens between samples is unknown.
inline constexpr double kLeastImuRateHz = 50.0;

/// Samples in order of time; those that are there twice, and those of a time that is taken, left
/// out and counted. Refused where more than a tenth has the time of another.
void PutInOrder(ImuData& data);

/// Leaves out what a sensor repeats for over a second, all six numbers the same.
void LeaveOutStuck(ImuData& data);

/// Counts the times without samples, of three steps or more, and names the longest.
void WarnOfGaps(ImuData& data);

/// Where an axis has its extreme value three times in a row or more, beyond the smallest ranges
/// that sensors have (2 g, 125 degrees a second), the range ends there.
void FindRanges(ImuData& data);

/// All of these, and the rate: refused below 50 samples a second.
void CleanImu(ImuData& data);

/// Refused where no image has its time among the samples; a warning where some have not. The times
/// are those of the images, in order, not empty.
void CheckCoverage(const std::vector<int64_t>& image_times_ns, ImuData& data);

}  // namespace gluevo::vo
