#include "gluevo/vo/evaluation/segment_evaluation.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "gluevo/nn/error.h"
#include "pose_association.h"

namespace gluevo::vo {
namespace {

constexpr std::size_t kFewestPairs = 3;

// Associated poses as two trajectories that associate one to one. Times count the pairs, because
// two of them may share a pose.
Evaluation EvaluatePairs(const std::vector<PosePair>& pairs, const EvaluationOptions& options) {
  constexpr int64_t kSecond = 1'000'000'000;
  Trajectory estimate;
  Trajectory groundtruth;
  for (const PosePair& pair : pairs) {
    const int64_t timestamp_ns = static_cast<int64_t>(estimate.size()) * kSecond;
    estimate.push_back({timestamp_ns, pair.estimate->world_from_body});
    groundtruth.push_back({timestamp_ns, pair.groundtruth->world_from_body});
  }
  EvaluationOptions one_to_one = options;
  one_to_one.max_time_difference_s = 0.0;
  return Evaluate(estimate, groundtruth, one_to_one);
}

}  // namespace

SegmentedEvaluation EvaluateSegments(const Trajectory& estimate,
                                     const std::vector<int>& segment_of_pose,
                                     const Trajectory& groundtruth,
                                     const EvaluationOptions& options) {
  if (segment_of_pose.size() != estimate.size() ||
      !std::is_sorted(segment_of_pose.begin(), segment_of_pose.end())) {
    throw Error("segments of " + std::to_string(segment_of_pose.size()) + " poses for " +
                std::to_string(estimate.size()) + ", expected one rising number a pose");
  }
  const std::vector<PosePair> pairs = AssociatePoses(estimate, groundtruth, options);
  const auto segment_of = [&](const PosePair& pair) {
    return segment_of_pose[static_cast<std::size_t>(pair.estimate - estimate.data())];
  };
  SegmentedEvaluation result;
  double squares = 0.0;
  for (auto begin = pairs.begin(); begin != pairs.end();) {
    const int number = segment_of(*begin);
    const auto end = std::find_if(begin, pairs.end(),
                                  [&](const PosePair& pair) { return segment_of(pair) != number; });
    const std::vector<PosePair> members(begin, end);
    SegmentedEvaluation::Segment segment = {.number = number, .pairs = members.size()};
    result.breaks += begin != pairs.begin() ? 1 : 0;
    result.motions += members.size() - 1;
    for (std::size_t i = 1; i < members.size(); ++i) {
      result.correct_motions += IsCorrectMotion(members[i - 1], members[i], options) ? 1 : 0;
    }
    if (members.size() >= kFewestPairs) {
      segment.evaluation = EvaluatePairs(members, options);
      squares += static_cast<double>(members.size()) * segment.evaluation->ate_se3_m *
                 segment.evaluation->ate_se3_m;
      result.pairs_within_segments += members.size();
    }
    result.segments.push_back(segment);
    begin = end;
  }
  // 0 / 0 is NaN: no segment long enough.
  result.ate_within_segments_m =
      std::sqrt(squares / static_cast<double>(result.pairs_within_segments));
  return result;
}

}  // namespace gluevo::vo
