#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gluevo/vo/core/frame_result.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/global_adjustment.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/place_codebook.h"
#include "gluevo/vo/mapping/place_map.h"

namespace gluevo::vo {

/// Looks over odometry's shoulder: keeps some of its key frames, finds where it has been before,
/// and at the end knows all poses better. Odometry itself goes on as it would without.
class LoopRecorder {
 public:
  /// `extractor` finds what the codebook knows. Throws Error for options out of their range.
  LoopRecorder(const StereoRig& rig, PlaceCodebook codebook,
               std::shared_ptr<FeatureExtractor> extractor, std::shared_ptr<Matcher> matcher,
               const LoopOptions& options);

  /// Comes back to the places of a map, too, before any frame; they stay in Map(). Throws Error
  /// naming `map_name` where the map is of another rig.
  void Load(const PlaceMap& map, const std::string& map_name);

  /// To be called after every frame; one without images is no place to come back to, but has a
  /// pose. `rig`: Odometry's. `known`: what the extractor would find, of
  /// the front end's, if it has such a one (ExtractorMemo). Throws what the networks throw.
  void Add(const StereoFrame& frame, const FrameResult& result, const StereoRig& rig,
           KnownFeatures known = {});
  /// Whether Add may look at the frame's images; of others none need be given.
  static bool MayKeep(const FrameResult& result) {
    return result.is_keyframe || result.is_predicted;
  }

  const LoopCloser& closer() const { return closer_; }

  /// A pose for every frame by those of all kept key frames (closer().Optimized(), or better ones):
  /// the motion between two of them is odometry's but for a smooth bend.
  Trajectory Follow(const std::vector<Rigid3>& keyframes) const;
  /// AdjustGlobally by the recorder's own matcher, from closer().Optimized() or the like.
  GlobalAdjustment Adjust(const std::vector<Rigid3>& keyframes,
                          const GlobalAdjustmentOptions& options) const;
  /// Of each frame the oldest segment that loops link with its own.
  std::vector<int> LinkedSegments() const;
  /// How many segments of the run hang together with older ones, those of a loaded map too.
  int JoinedSegments() const;
  bool has_loaded_map() const { return loaded_keyframes_ > 0; }
  /// How many frames are in segments that loops link with a loaded map.
  std::size_t FramesInLoadedMap() const;

 private:
  struct Frame {
    StampedPose pose;
    int segment = 0;  ///< Behind those of a loaded map.
  };

  /// A frame that is kept, or may be: its pose was only predicted.
  struct Pending {
    StereoFrame frame;
    FrameResult result;
    KnownFeatures known;
  };

  bool IsToBeKept(const FrameResult& result) const;
  bool IsLater(int segment, int64_t timestamp_ns) const;
  void Revise(const Trajectory& window);
  void Keep(Pending kept, int segment, const StereoRig& rig);

  std::shared_ptr<FeatureExtractor> extractor_;
  std::shared_ptr<Matcher> matcher_;
  LoopOptions options_;
  LoopCloser closer_;
  std::size_t loaded_keyframes_ = 0;
  int loaded_segments_ = 0;
  std::vector<Frame> frames_;
  std::vector<Rigid3>
      revised_;  // Of this run's key frames that are kept, as odometry has them now.
  /// Of the motion from the newest key frame that is kept to odometry's newest one.
  PoseCovariance since_kept_ = PoseCovariance::Zero();
  /// Since the last frame that was located: if none is any more before tracking is lost, loops are
  /// all that can tell where these were.
  std::vector<Pending> pending_;
};

}  // namespace gluevo::vo
