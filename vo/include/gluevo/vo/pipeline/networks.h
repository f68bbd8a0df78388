#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "gluevo/nn/aliked.h"
#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/matcher.h"

namespace gluevo::vo {

/// Which weights the networks have.
struct NetworkFiles {
  /// Folder with superpoint.safetensors, superglue.safetensors, aliked.safetensors and
  /// lightglue.safetensors, or one file of each kind, .npz too: names that begin with the
  /// network's, a LightGlue's with it anywhere. Of several, aliked-n16 and the LightGlue that is
  /// named for the features count. Empty for the user's own folder (nn::UserWeightsFolder) where
  /// ALIKED and LightGlue are concerned, and the built-in open weights of SuperPoint and SuperGlue.
  std::filesystem::path weights;
  /// Files that come before what the folder holds; empty for none.
  std::filesystem::path superpoint, superglue, aliked, lightglue;
  /// Of SuperGlue's products: "float" or "bf16".
  std::string precision = "float";
};

/// Name and checksum of a network's weights, for records.
struct WeightsRecord {
  std::string network;  ///< "superpoint", "superglue", "aliked" or "lightglue".
  std::string source;
  std::string checksum;
};

/// What was loaded: at most one network of features and one that matches.
struct Networks {
  std::vector<WeightsRecord> records;
  std::shared_ptr<const nn::SuperPoint> superpoint;
  std::shared_ptr<const nn::Aliked> aliked;
  std::shared_ptr<const nn::SuperGlue> superglue;
  std::shared_ptr<const nn::LightGlue> lightglue;
};

/// How an image's keypoints are chosen, whichever network finds them.
struct KeypointOptions {
  /// Keypoints have a score above this, 0 to 1. The two networks' scores are not alike: 0.005 suits
  /// SuperPoint, 0.2 ALIKED.
  float keypoint_threshold = 0.005F;
  /// The best so many are kept.
  int max_keypoints = 1024;
  /// nn::SuperPointOptions'; ALIKED's keypoints never lie on whole pixels.
  bool subpixel = false;

  /// Throws Error naming the field that is out of range.
  void Validate() const;
};

/// The threshold of keypoints that suits the features ("superpoint" or "aliked") best: as
/// published.
float UsualKeypointThreshold(const std::string& features);
/// The confidence above which the matcher's pairs are matches, as published: SuperGlue's 0.2,
/// LightGlue's 0.1.
float UsualMatchThreshold(const std::string& matcher);

/// `matcher`, or where that is empty what goes with the features: "superglue" with "superpoint",
/// "lightglue" with "aliked".
std::string MatcherOf(const std::string& features, const std::string& matcher);

/// Throws Error naming the option unless features are "superpoint" or "aliked" and the matcher
/// "superglue", "lightglue", "nn" or empty, and SuperGlue is not to match ALIKED's, for which there
/// is none.
void CheckNetworkNames(const std::string& features, const std::string& matcher);

/// Loads what finds `features` ("superpoint" or "aliked") and what matches them ("superglue" or
/// "lightglue"; "nn" or empty for nothing). Throws Error as CheckNetworkNames does, for weights
/// that are not there, cannot be read, are another network's, or do not fit each other by the size
/// of descriptors or by what a LightGlue's metadata say ("features"), and where `files` name a file
/// for a network in whose place another one is chosen, or a folder without any of these networks.
Networks LoadNetworks(const NetworkFiles& files, const std::string& features,
                      const std::string& matcher);

/// The same without what finds features, for those that are there already; empty where it is not
/// known whose they are.
Networks LoadMatcher(const NetworkFiles& files, const std::string& features,
                     const std::string& matcher);

/// The networks as the front ends know them. The pool must outlive what is returned.
std::unique_ptr<FeatureExtractor> MakeExtractor(const Networks& networks,
                                                const KeypointOptions& options,
                                                nn::ThreadPool& pool);
/// SuperGlue or LightGlue, or mutual nearest neighbours where neither was loaded.
std::unique_ptr<Matcher> MakeMatcher(const Networks& networks, nn::ThreadPool& pool,
                                     const nn::LightGlueOptions& lightglue = {});

}  // namespace gluevo::vo
