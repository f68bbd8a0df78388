#pragma once

#include <memory>
#include <string>

#include "gluevo/nn/lightglue.h"
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
  /// What finds and describes keypoints in both: "superpoint" or "aliked", which have other
  /// thresholds and refinement (PresetConfig knows them).
  std::string features = "superpoint";
  /// What matches keypoints in Method 2: "superglue", "lightglue", or "nn" for mutual nearest
  /// neighbours; empty: what goes with the features (MatcherOf).
  std::string matcher;
  /// Keypoints below the pixel: "none", "subpixel" (peaks of SuperPoint's scores) or "lk" (optical
  /// flow between matched points). Decides over the `refine` and `subpixel` of the options below.
  std::string refine = "lk";
  /// What matches from left to right in Method 2: "band" (nearest descriptors near the epipolar
  /// line) or "network" (the matcher, as Yoon and Park have it). Decides over `learned`'s
  /// stereo_in_band.
  std::string stereo_matching = "band";
  NetworkFiles networks;
  KeypointOptions keypoints = {.keypoint_threshold = 0.005F, .max_keypoints = 500};
  /// Its match_threshold is not used: `learned` has those of tracking and stereo.
  nn::LightGlueOptions lightglue;
  LearnedFrontEndOptions learned;
  /// Its klt, refine and max_epipolar_error_px are the others'.
  SuperPointFrontEndOptions stereo;
  KltOptions klt;
  /// Which images are taken for the ones before, given again.
  FreezeGuardOptions freeze;

  /// Throws Error naming the option.
  void Validate() const;
};

/// What matches in Method 2, by name; empty for the other methods, which have no matcher.
std::string MatcherOf(const FrontEndConfig& config);

/// The networks that the front end runs; none for klt. Throws Error as Validate and LoadNetworks
/// do.
Networks LoadFrontEndNetworks(const FrontEndConfig& config);

/// What finds the keypoints in the front ends that have networks. The pool must outlive it. Throws
/// Error for options out of their range.
std::unique_ptr<FeatureExtractor> MakeFrontEndExtractor(const FrontEndConfig& config,
                                                        const Networks& networks,
                                                        nn::ThreadPool& pool);

/// The pool must outlive it. `extractor`: one that others ask, too; none, or where networks run
/// beside tracking: one of its own. Throws Error for options out of their range.
std::unique_ptr<FrontEnd> MakeFrontEnd(const FrontEndConfig& config, const StereoRig& rig,
                                       const Networks& networks, nn::ThreadPool& pool,
                                       std::shared_ptr<FeatureExtractor> extractor = nullptr);

}  // namespace gluevo::vo
