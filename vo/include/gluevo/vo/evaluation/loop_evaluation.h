#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/core/trajectory.h"

namespace gluevo::vo {

struct LoopEvaluationOptions {
  /// Two key frames are of one place where the truth has them within these, ...
  double max_distance_m = 1.0;
  double max_angle_deg = 30.0;
  /// ... and the later one comes back to it where it is so much younger.
  double min_age_s = 20.0;
  /// A loop is right within these.
  double right_m = 0.3;
  double right_deg = 5.0;
  /// A key frame's truth is the nearest pose within this time, seconds.
  double max_time_difference_s = 0.01;

  /// Throws Error naming the option.
  void Validate() const;
};

/// A key frame that a run could have come back to.
struct PlaceVisit {
  int64_t timestamp_ns = 0;
  int segment = 0;  ///< As FrameResult::segment.
};

/// A loop that a run believed.
struct BelievedLoop {
  std::size_t candidate = 0;  ///< Indices of the visits, the older one's and the younger one's.
  std::size_t query = 0;
  Rigid3 candidate_from_query;       ///< As it was measured, ...
  Rigid3 candidate_from_query_kept;  ///< ... and as the poses have it that it was used for.
  int64_t believed_ns = 0;           ///< Time of the key frame that made it believed.
};

/// Which places a run came back to, and of how many it knew.
struct LoopEvaluation {
  std::size_t revisits = 0;  ///< Key frames that come back to a place.
  std::size_t found = 0;     ///< Of these, those with a right loop.
  std::size_t loops = 0;     ///< That were believed, both ends with truth.
  std::size_t wrong = 0;     ///< Of these.
  /// Of the wrong ones, those that the poses agree with, within what is right.
  std::size_t wrong_kept = 0;
  std::optional<double> recall;     ///< found / revisits; nothing where there were none.
  std::optional<double> precision;  ///< 1 - wrong / loops; the same.
  /// A later segment that came to a place of an earlier one.
  struct Join {
    int segment = 0;
    int64_t seen_ns = 0;                         ///< Its first key frame at such a place.
    std::optional<double> joined_after_seconds;  ///< Until a loop to an earlier one was believed.
  };
  std::vector<Join> joins;
};

/// `visits` in order of time within each segment, segments in order. Throws Error for loops between
/// visits that there are not.
LoopEvaluation EvaluateLoops(const std::vector<PlaceVisit>& visits,
                             const std::vector<BelievedLoop>& loops, const Trajectory& groundtruth,
                             const LoopEvaluationOptions& options);

}  // namespace gluevo::vo
