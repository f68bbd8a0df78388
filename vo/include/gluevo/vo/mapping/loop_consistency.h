#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gluevo/vo/mapping/loop_keyframe.h"
#include "gluevo/vo/mapping/loop_verification.h"

namespace gluevo::vo {

/// A verified pair of key frames, by their indices.
struct Loop {
  std::size_t candidate = 0;  ///< The older one.
  std::size_t query = 0;
  LoopMeasurement measurement;
  int inliers = 0;  ///< Points that fit it.
};

enum class LoopTrust : std::uint8_t {
  kTrusted,
  kUnsupported,  ///< Until others agree with it.
  kImpossible,   ///< Odometry cannot be as wrong as that.
};

struct LoopConsistencyOptions {
  /// Squared standard deviations (six degrees of freedom, 99.9 %) within which a loop agrees with
  /// odometry, or two loops with each other.
  double max_error = 22.5;
  /// A loop that bends the path by so many times odometry's standard deviation is a place that
  /// looks alike.
  double max_bend = 10.0;
  /// So many others must agree with a loop between these limits, and with one between segments ...
  int supporters = 2;
  /// ... unless so many points fit that one.
  int strong_inliers = 60;
  /// Others whose key frames are nearer in time than this show the same, seconds.
  double min_apart_s = 1.0;

  /// Throws Error naming the option.
  void Validate() const;
};

/// What odometry says of the motion between two key frames of a segment, a before b.
LoopMeasurement OdometryBetween(const std::vector<LoopKeyframe>& keyframes, std::size_t a,
                                std::size_t b);

/// Whether to believe a verified loop, by odometry's own uncertainty and by the other verified
/// loops (pairwise consistency: Mangelson et al. 2018).
LoopTrust Judge(const Loop& loop, const std::vector<Loop>& others,
                const std::vector<LoopKeyframe>& keyframes, const LoopConsistencyOptions& options);

}  // namespace gluevo::vo
