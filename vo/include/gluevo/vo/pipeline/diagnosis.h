#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "gluevo/vo/core/count_median.h"
#include "gluevo/vo/core/frame_result.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/frontend/stereo_look.h"
#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// What tells why frames of a run could not be located.
struct RunEvidence {
  double baseline_m = 0.0;
  bool uses_networks = false;
  int frames = 0;
  int located = 0;                     ///< Frames whose pose was found from points seen before.
  std::vector<StereoLook> looks;       ///< At some of the others.
  std::vector<double> steps_s;         ///< From frame to frame, of the first ones.
  std::vector<double> refused_speeds;  ///< FrameResult::refused_speed_m_per_s where not 0.
  double matched = 0.0;                ///< Medians over frames, as FrameResult counts.
  double inliers = 0.0;
  double stereo = 0.0;
};

/// Why tracking yields next to nothing, or was lost: a sentence a cause that the evidence bears
/// out, the likeliest first; none where all went well or nothing is known.
std::vector<std::string> Causes(const RunEvidence& evidence);

/// Gathers the evidence while a run goes on. Costs nothing while frames are located; of the others
/// the 1st, 2nd, 4th, 8th ... is looked at, some ten milliseconds each.
class Diagnosis {
 public:
  Diagnosis(const StereoRig& rig, bool uses_networks);

  /// The next frame and what became of it. Its images may be absent (a replay): nothing is looked
  /// at then.
  void Add(const StereoFrame& frame, const FrameResult& result);

  RunEvidence evidence() const;
  std::vector<std::string> Causes() const { return vo::Causes(evidence()); }

 private:
  StereoRig rig_;
  RunEvidence evidence_;
  internal::CountMedian matched_, inliers_, stereo_;
  cv::Mat left_before_;
  int64_t last_timestamp_ns_ = 0;
  int bad_frames_ = 0;
};

}  // namespace gluevo::vo
