#pragma once

#include <memory>
#include <string>

#include "gluevo/nn/superpoint.h"
#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/freeze_guard.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/frontend/klt_frontend.h"
#include "gluevo/vo/frontend/learned_frontend.h"
#include "gluevo/vo/frontend/superpoint_frontend.h"
#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::vo {

/// Which front end there is, by names, and the options of all.
struct FrontEndConfig {
  /// "superglue" (Method 2 of Yoon and Park: LearnedFrontEnd), "superpoint" (Method 1:
  /// SuperPointFrontEnd) or "klt" (the baseline: KltFrontEnd).
  std::string method = "superglue";
  /// What matches keypoints in Method 2: "superglue", or "nn" for mutual nearest neighbours.
  std::string matcher = "superglue";
  /// Keypoints below the pixel: "none", "subpixel" (peaks of SuperPoint's scores) or "lk" (optical
  /// flow between matched points). Decides over the `refine` and `subpixel` of the options below.
  std::string refine = "lk";
  NetworkFiles networks;
  nn::SuperPointOptions superpoint = {.keypoint_threshold = 0.005F, .max_keypoints = 500};
  LearnedFrontEndOptions learned;
  /// Its klt, refine and max_epipolar_error_px are the others'.
  SuperPointFrontEndOptions stereo;
  KltOptions klt;
  /// Which images are taken for the ones before, given again.
  FreezeGuardOptions freeze;

  /// Throws Error naming the option.
  void Validate() const;
};

/// The networks that the front end runs; none for klt. Throws Error as LoadNetworks does.
Networks LoadFrontEndNetworks(const FrontEndConfig& config);

/// The pool must outlive it. Throws Error for options out of their range.
std::unique_ptr<FrontEnd> MakeFrontEnd(const FrontEndConfig& config, const StereoRig& rig,
                                       const Networks& networks, nn::ThreadPool& pool);

}  // namespace gluevo::vo
