#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/geometry/pnp.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/place_codebook.h"
#include "gluevo/vo/mapping/place_index.h"
#include "gluevo/vo/mapping/place_map.h"

namespace gluevo::vo {

struct LocalizationOptions {
  /// So many key frames of the map are matched with a frame, the most similar first, until one
  /// agrees well with it.
  int max_candidates = 10;
  /// A pose that so many points of one key frame fit needs no other candidate, once so many were
  /// tried: of places that look alike the others come next.
  int enough_inliers = 80;
  int min_candidates = 3;
  /// No pose where another one, farther away than this in the same part of the map, has this share
  /// of its points.
  double max_rival_share = 0.7;
  double rival_distance_m = 1.0;
  /// Key frames near the pose that was found, which then count, too.
  int max_neighbours = 3;
  float match_threshold = 0.2F;  ///< Confidence of a match, 0 to 1.
  /// Keypoints that must fit the pose, by the points of all key frames.
  int min_inliers = 25;
  /// Of the points of the key frame that fits best, so many and this share of those that are
  /// matched, 0 to 1. Other places have half as many.
  int min_keyframe_inliers = 25;
  double min_inlier_share = 0.2;
  /// The same where the pose is next to a key frame, which then shows what the frame shows: within
  /// this share of its points' median depth and this angle.
  double min_near_share = 0.4;
  double near_depth_share = 0.15;
  double near_rad = 0.15;
  /// Of the sixteen fields of the image (4 x 4) so many must hold a point that fits.
  int min_fields = 5;
  /// The standard deviation that the points leave the pose, in the worst direction.
  double max_position_sigma_m = 0.1;
  double max_rotation_sigma_rad = 0.01;
  /// Its bounds on the uncertainty and min_inliers are those of a hypothesis.
  PnpOptions pnp = {.noise_px = 2.5};

  /// Throws Error naming the option.
  void Validate() const;
};

/// Where a frame was taken.
struct Localization {
  bool is_found = false;
  std::string reason;  ///< Why it is not.
  /// In the frame of the part of the map.
  Rigid3 map_from_body;
  PoseCovariance covariance = PoseCovariance::Zero();
  int part = 0;              ///< As PlaceMap::Parts.
  std::size_t keyframe = 0;  ///< Of the map, whose points fit best.
  double similarity = 0.0;   ///< Of its place descriptor to the frame's.
  int matches = 0;           ///< Of the frame's keypoints with points of the map.
  int inliers = 0;           ///< Keypoints that fit the pose.
  double inlier_share = 0.0;
  double position_sigma_m = 0.0;
  double rotation_sigma_rad = 0.0;
};

/// Finds frames in a map, each by itself: nothing is known of the frames before.
class MapLocalizer {
 public:
  /// The codebook, the extractor and the matcher are of the map's features. Throws Error for
  /// options out of their range and where the codebook does not fit.
  MapLocalizer(PlaceMap map, PlaceCodebook codebook, std::shared_ptr<FeatureExtractor> extractor,
               std::shared_ptr<Matcher> matcher, const LocalizationOptions& options);

  const PlaceMap& map() const { return map_; }

  /// `rig`: the one that took the frame, which need not be the map's. Without a right image (an
  /// empty one) the left one has to do. Throws what the networks throw.
  Localization Locate(const StereoFrame& frame, const StereoRig& rig) const;

 private:
  struct Search;

  std::vector<std::size_t> MostSimilar(const Eigen::VectorXf& place) const;
  /// Key frames of the part that look at what is seen from the pose, the nearest first.
  std::vector<std::size_t> Neighbours(const Rigid3& map_from_body, int part) const;
  void Try(std::size_t keyframe, Search& search) const;
  bool IsNextTo(const Rigid3& map_from_body, std::size_t keyframe) const;
  bool HasRival(const Search& search, int part) const;
  void Decide(const Search& search, Localization& result) const;

  PlaceMap map_;
  std::vector<int> parts_;
  PlaceCodebook codebook_;
  std::shared_ptr<FeatureExtractor> extractor_;
  std::shared_ptr<Matcher> matcher_;
  LocalizationOptions options_;
  PlaceIndex places_;  // One a key frame.
};

}  // namespace gluevo::vo
