#pragma once

#include <vector>

#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/geometry/pnp.h"
#include "gluevo/vo/mapping/loop_keyframe.h"

namespace gluevo::vo::internal {

/// Fills in the keyframe's features and keypoints, with depths where the frame has a right image,
/// too. `known`: what the extractor would find. `threshold`: confidence of a match, 0 to 1.
void FindKeypoints(const StereoFrame& frame, KnownFeatures known, const StereoRig& rig,
                   FeatureExtractor& extractor, Matcher& matcher, float threshold,
                   LoopKeyframe& keyframe);

/// Of the sixteen fields of the image (4 x 4) how many hold one of these keypoints.
int CountFields(const nn::Features& features, const std::vector<int>& keypoints);

/// What PnP knows of a key frame's keypoint that has a depth: `world_from_left` is the pose of its
/// camera, `noise_px` (of kReferenceFocalPx) what its depth is as good as.
AnchoredPoint PointOf(const StereoKeypoint& keypoint, const Rigid3& world_from_left,
                      double noise_px, double baseline);

}  // namespace gluevo::vo::internal
