#include "gluevo/vo/mapping/map_localizer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "gluevo/vo/core/median.h"
#include "gluevo/vo/core/options_check.h"
#include "keyframe_views.h"

namespace gluevo::vo {

/// A frame, and what the key frames that were tried say of it.
struct MapLocalizer::Search {
  /// What one part of the map says.
  struct Part {
    std::vector<PnpObservation> observations;
    std::vector<int> keypoints;          // Of the frame, one an observation.
    std::vector<std::size_t> keyframes;  // Of the map, one an observation.
    std::vector<Rigid3> guesses;         // Poses that a key frame alone gives.
    std::vector<int> inliers;            // Of these.
    int most_inliers = 0;                // Of these.
    Rigid3 best_guess;
  };

  const StereoRig& rig;
  LoopKeyframe frame;
  std::set<std::size_t> tried;
  std::map<int, Part> parts;
};

namespace {

PnpOptions HypothesisOptions(const LocalizationOptions& options) {
  PnpOptions pnp = options.pnp;
  // One that is good for little alone may be what others agree with.
  pnp.max_position_sigma_m = std::max(pnp.max_position_sigma_m, options.max_position_sigma_m);
  pnp.max_rotation_sigma_rad = std::max(pnp.max_rotation_sigma_rad, options.max_rotation_sigma_rad);
  return pnp;
}

}  // namespace

void LocalizationOptions::Validate() const {
  CheckAtLeast(max_candidates, 1, "localization.max_candidates (--candidates)");
  CheckAtLeast(enough_inliers, 4, "localization.enough_inliers");
  CheckAtLeast(min_candidates, 1, "localization.min_candidates");
  CheckWithin(max_rival_share, 0.0, 1.0, "localization.max_rival_share");
  CheckPositive(rival_distance_m, "localization.rival_distance_m");
  CheckAtLeast(max_neighbours, 0, "localization.max_neighbours");
  CheckWithin(match_threshold, 0.0, 1.0, "localization.match_threshold");
  CheckAtLeast(min_inliers, 4, "localization.min_inliers (--min-inliers)");
  CheckAtLeast(min_keyframe_inliers, 4, "localization.min_keyframe_inliers");
  CheckWithin(min_inlier_share, 0.0, 1.0, "localization.min_inlier_share");
  CheckWithin(min_near_share, 0.0, 1.0, "localization.min_near_share");
  CheckPositive(near_depth_share, "localization.near_depth_share");
  CheckPositive(near_rad, "localization.near_rad");
  CheckAtLeast(min_fields, 1, "localization.min_fields");
  CheckPositive(max_position_sigma_m, "localization.max_position_sigma_m (--max-sigma)");
  CheckPositive(max_rotation_sigma_rad, "localization.max_rotation_sigma_rad");
  pnp.Validate();
}

MapLocalizer::MapLocalizer(PlaceMap map, PlaceCodebook codebook,
                           std::shared_ptr<FeatureExtractor> extractor,
                           std::shared_ptr<Matcher> matcher, const LocalizationOptions& options)
    : map_(std::move(map)),
      parts_(map_.Parts()),
      codebook_(std::move(codebook)),
      extractor_(std::move(extractor)),
      matcher_(std::move(matcher)),
      options_(options) {
  options_.Validate();
  for (const LoopKeyframe& keyframe : map_.keyframes) {
    places_.Add(codebook_.Describe(keyframe.features));
  }
}

std::vector<std::size_t> MapLocalizer::MostSimilar(const Eigen::VectorXf& place) const {
  std::vector<std::size_t> keyframes;
  for (const PlaceIndex::Similar& similar : places_.MostSimilar(
           place, places_.size(), static_cast<std::size_t>(options_.max_candidates))) {
    keyframes.push_back(similar.place);
  }
  return keyframes;
}

std::vector<std::size_t> MapLocalizer::Neighbours(const Rigid3& map_from_body, int part) const {
  // Half a metre aside costs as much of the common view as a quarter of a turn's sixth.
  constexpr double kMetresARadian = 2.0;
  constexpr double kLargest = 3.0;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Rigid3& pose = map_.map_from_body[i];
    const double distance = (pose.translation - map_from_body.translation).norm() +
                            kMetresARadian * pose.rotation.angularDistance(map_from_body.rotation);
    if (parts_[i] == part && distance < kLargest) {
      order.emplace_back(distance, i);
    }
  }
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> keyframes;
  keyframes.reserve(order.size());
  for (const auto& [distance, keyframe] : order) {
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

void MapLocalizer::Try(std::size_t keyframe, Search& search) const {
  if (!search.tried.insert(keyframe).second) {
    return;
  }
  const LoopKeyframe& known = map_.keyframes[keyframe];
  const Rigid3 map_from_left = map_.map_from_body[keyframe] * map_.rig.body_from_cam[0];
  const double baseline = map_.rig.baseline();
  const nn::Matches matches =
      matcher_->Match(known.features, search.frame.features, options_.match_threshold);
  Search::Part& part = search.parts[parts_[keyframe]];
  std::vector<PnpObservation> own;
  for (std::size_t i = 0; i < matches.matches0.size(); ++i) {
    if (matches.matches0[i] < 0) {
      continue;
    }
    const StereoKeypoint& view = search.frame.keypoints[matches.matches0[i]];
    if (known.keypoints[i].inverse_depth <= 0.0 || !known.keypoints[i].left.allFinite() ||
        !view.left.allFinite()) {
      continue;
    }
    own.push_back({.point = internal::PointOf(known.keypoints[i], map_from_left,
                                              options_.pnp.noise_px, baseline),
                   .left = view.left,
                   .has_right = view.has_right,
                   .right = view.right});
    part.keypoints.push_back(matches.matches0[i]);
    part.keyframes.push_back(keyframe);
  }
  part.observations.insert(part.observations.end(), own.begin(), own.end());
  const std::optional<PnpResult> pose =
      SolvePnp(search.rig, own, part.guesses, HypothesisOptions(options_));
  if (!pose) {
    return;
  }
  part.guesses.push_back(pose->world_from_body);
  part.inliers.push_back(pose->inliers);
  if (pose->inliers > part.most_inliers) {
    part.most_inliers = pose->inliers;
    part.best_guess = pose->world_from_body;
  }
}

bool MapLocalizer::IsNextTo(const Rigid3& map_from_body, std::size_t keyframe) const {
  std::vector<double> inverse_depths;
  for (const StereoKeypoint& keypoint : map_.keyframes[keyframe].keypoints) {
    if (keypoint.inverse_depth > 0.0) {
      inverse_depths.push_back(keypoint.inverse_depth);
    }
  }
  const Rigid3& pose = map_.map_from_body[keyframe];
  return (pose.translation - map_from_body.translation).norm() * Median(inverse_depths) <
             options_.near_depth_share &&
         pose.rotation.angularDistance(map_from_body.rotation) < options_.near_rad;
}

bool MapLocalizer::HasRival(const Search& search, int part) const {
  const Search::Part& poses = search.parts.at(part);
  for (std::size_t i = 0; i < poses.guesses.size(); ++i) {
    const double distance = (poses.guesses[i].translation - poses.best_guess.translation).norm();
    if (distance > options_.rival_distance_m &&
        poses.inliers[i] >= options_.max_rival_share * poses.most_inliers) {
      return true;
    }
  }
  return false;
}

void MapLocalizer::Decide(const Search& search, Localization& result) const {
  const Search::Part& part = search.parts.at(result.part);
  const std::optional<PnpResult> pose =
      SolvePnp(search.rig, part.observations, part.guesses, HypothesisOptions(options_));
  if (!pose) {
    result.reason = "no pose fits";
    return;
  }
  std::set<int> fitting;
  std::map<std::size_t, std::pair<int, int>> of_keyframes;  // Inliers and all.
  for (std::size_t i = 0; i < part.keypoints.size(); ++i) {
    auto& [inliers, all] = of_keyframes[part.keyframes[i]];
    ++all;
    if (pose->verdicts[i] != PnpVerdict::kOutlier) {
      fitting.insert(part.keypoints[i]);
      ++inliers;
    }
  }
  const auto best = std::max_element(
      of_keyframes.begin(), of_keyframes.end(),
      [](const auto& a, const auto& b) { return a.second.first < b.second.first; });
  result.map_from_body = pose->world_from_body;
  result.covariance = pose->covariance;
  result.position_sigma_m = pose->position_sigma_m;
  result.rotation_sigma_rad = pose->rotation_sigma_rad;
  result.keyframe = best->first;
  result.inliers = static_cast<int>(fitting.size());
  result.inlier_share = static_cast<double>(best->second.first) / best->second.second;
  std::vector<double> near_shares;
  for (const auto& [keyframe, counts] : of_keyframes) {
    if (IsNextTo(pose->world_from_body, keyframe)) {
      near_shares.push_back(static_cast<double>(counts.first) / counts.second);
    }
  }
  const bool fits_near =
      near_shares.empty() ||
      *std::max_element(near_shares.begin(), near_shares.end()) >= options_.min_near_share;
  const int fields = internal::CountFields(search.frame.features, {fitting.begin(), fitting.end()});
  if (result.inliers < options_.min_inliers || best->second.first < options_.min_keyframe_inliers ||
      result.inlier_share < options_.min_inlier_share) {
    result.reason = std::to_string(result.inliers) + " keypoints fit, " +
                    std::to_string(best->second.first) + " of " +
                    std::to_string(best->second.second) + " points of a key frame";
  } else if (!fits_near) {
    result.reason = "a key frame that would show the same does not";
  } else if (fields < options_.min_fields) {
    result.reason = "all points in " + std::to_string(fields) + " of 16 fields of the image";
  } else if (pose->position_sigma_m > options_.max_position_sigma_m ||
             pose->rotation_sigma_rad > options_.max_rotation_sigma_rad) {
    result.reason = "the pose is too uncertain";
  } else {
    result.is_found = true;
  }
}

Localization MapLocalizer::Locate(const StereoFrame& frame, const StereoRig& rig) const {
  Search search{.rig = rig, .frame = {}, .tried = {}, .parts = {}};
  internal::FindKeypoints(frame, {}, rig, *extractor_, *matcher_, options_.match_threshold,
                          search.frame);
  const Eigen::VectorXf place = codebook_.Describe(search.frame.features);
  Localization result;
  int most_inliers = 0;
  for (const std::size_t keyframe : MostSimilar(place)) {
    Try(keyframe, search);
    const int inliers = search.parts[parts_[keyframe]].most_inliers;
    if (inliers > most_inliers) {
      most_inliers = inliers;
      result.part = parts_[keyframe];
    }
    if (most_inliers >= options_.enough_inliers &&
        static_cast<int>(search.tried.size()) >= options_.min_candidates) {
      break;
    }
  }
  if (most_inliers == 0) {
    result.reason = map_.keyframes.empty() ? "the map is empty" : "no key frame shows the same";
    return result;
  }
  if (HasRival(search, result.part)) {
    result.reason = "two places fit";
    return result;
  }
  int neighbours = 0;
  for (const std::size_t keyframe : Neighbours(search.parts[result.part].best_guess, result.part)) {
    if (neighbours < options_.max_neighbours && !search.tried.contains(keyframe)) {
      Try(keyframe, search);
      ++neighbours;
    }
  }
  const std::vector<int>& matched = search.parts[result.part].keypoints;
  result.matches = static_cast<int>(std::set<int>(matched.begin(), matched.end()).size());
  Decide(search, result);
  result.similarity = place.dot(places_[result.keyframe]);
  return result;
}

}  // namespace gluevo::vo
