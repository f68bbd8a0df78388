#include <algorithm>
#include <iterator>
#include <limits>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/estimator/sliding_window.h"

// The choice of key frames (Qin et al. 2018, section IV-A).
namespace gluevo::vo {

void SlidingWindow::DecideKeyframe(std::size_t new_tracks) {
  Frame& newest = frames_.back();
  std::size_t tracked = 0;
  std::size_t long_tracked = 0;
  for (const auto& [id, landmark] : landmarks_) {
    if (landmark.observations > 1 && landmark.views.back().frame_id == newest.id) {
      ++tracked;
      long_tracked += landmark.observations >= options_.long_track;
    }
  }
  newest.lost_tracks = frames_.size() < 2 ||
                       tracked < static_cast<std::size_t>(options_.min_tracked) ||
                       long_tracked < static_cast<std::size_t>(options_.min_long_tracked) ||
                       static_cast<double>(new_tracks) > options_.max_new_share * tracked;
  newest.is_keyframe = newest.lost_tracks;
  if (!newest.is_keyframe) {
    const auto last_keyframe = std::find_if(std::next(frames_.rbegin()), frames_.rend(),
                                            [](const Frame& frame) { return frame.is_keyframe; });
    if (last_keyframe == frames_.rend()) {
      newest.is_keyframe = true;
      return;
    }
    const Overlap overlap = OverlapOf(*last_keyframe, newest);
    newest.is_keyframe = static_cast<double>(overlap.landmarks) <
                             options_.min_keyframe_overlap * static_cast<double>(tracked) ||
                         overlap.mean_parallax >= FromReferencePx(options_.keyframe_parallax_px);
  }
}

SlidingWindow::Overlap SlidingWindow::OverlapOf(const Frame& before, const Frame& now) const {
  const Eigen::Quaterniond& body_from_left = calibrated_rig_.body_from_cam[0].rotation;
  const Eigen::Quaterniond now_from_before =
      (now.world_from_body.rotation * body_from_left).conjugate() *
      (before.world_from_body.rotation * body_from_left);
  double sum = 0.0;
  int count = 0;
  for (const auto& [id, landmark] : landmarks_) {
    const auto& views = landmark.views;
    const auto see = [&views](int64_t frame_id) {
      return std::find_if(views.begin(), views.end(), [frame_id](const LandmarkView& view) {
        return view.frame_id == frame_id;
      });
    };
    const auto view_before = see(before.id);
    const auto view_now = see(now.id);
    if (view_before != views.end() && view_now != views.end()) {
      const Eigen::Vector3d turned = now_from_before * view_before->left.homogeneous();
      sum += (view_now->left - turned.hnormalized()).norm();
      ++count;
    }
  }
  // Frames that share nothing are as far apart as can be.
  return {count, count > 0 ? sum / count : std::numeric_limits<double>::infinity()};
}

}  // namespace gluevo::vo
