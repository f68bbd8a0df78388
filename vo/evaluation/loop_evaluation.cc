#include "gluevo/vo/evaluation/loop_evaluation.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/seconds.h"

namespace gluevo::vo {
namespace {

bool IsWithin(const Rigid3& motion, double metres, double degrees) {
  return motion.translation.norm() <= metres &&
         motion.rotation.angularDistance(Eigen::Quaterniond::Identity()) <= degrees * kDegree;
}

// Nothing where the truth has no pose at about this time.
std::optional<Rigid3> TruthAt(const Trajectory& groundtruth, int64_t timestamp_ns, double max_s) {
  const auto after = std::lower_bound(
      groundtruth.begin(), groundtruth.end(), timestamp_ns,
      [](const StampedPose& pose, int64_t time_ns) { return pose.timestamp_ns < time_ns; });
  std::optional<Rigid3> nearest;
  double least_s = max_s;
  for (auto pose = after == groundtruth.begin() ? after : after - 1;
       pose != groundtruth.end() && pose <= after; ++pose) {
    const double seconds = std::abs(SecondsBetween(pose->timestamp_ns, timestamp_ns));
    if (seconds <= least_s) {
      least_s = seconds;
      nearest = pose->world_from_body;
    }
  }
  return nearest;
}

using Truths = std::vector<std::optional<Rigid3>>;

bool IsSamePlace(const Truths& truths, std::size_t a, std::size_t b,
                 const LoopEvaluationOptions& options) {
  return truths[a] && truths[b] &&
         IsWithin(truths[a]->Inverse() * *truths[b], options.max_distance_m, options.max_angle_deg);
}

// Visits that come back to a place seen long enough before.
std::vector<bool> Revisits(const std::vector<PlaceVisit>& visits, const Truths& truths,
                           const LoopEvaluationOptions& options) {
  std::vector<bool> revisits(visits.size(), false);
  for (std::size_t i = 0; i < visits.size(); ++i) {
    for (std::size_t j = 0; j < visits.size() && !revisits[i]; ++j) {
      revisits[i] =
          SecondsBetween(visits[j].timestamp_ns, visits[i].timestamp_ns) > options.min_age_s &&
          IsSamePlace(truths, i, j, options);
    }
  }
  return revisits;
}

std::vector<LoopEvaluation::Join> Joins(const std::vector<PlaceVisit>& visits,
                                        const std::vector<BelievedLoop>& loops,
                                        const Truths& truths,
                                        const LoopEvaluationOptions& options) {
  std::vector<LoopEvaluation::Join> joins;
  for (std::size_t i = 0; i < visits.size(); ++i) {
    if (!joins.empty() && joins.back().segment == visits[i].segment) {
      continue;
    }
    for (std::size_t j = 0; j < i && visits[j].segment < visits[i].segment; ++j) {
      if (IsSamePlace(truths, i, j, options)) {
        joins.push_back({visits[i].segment, visits[i].timestamp_ns, std::nullopt});
        break;
      }
    }
  }
  for (LoopEvaluation::Join& join : joins) {
    for (const BelievedLoop& loop : loops) {
      if (visits[loop.query].segment == join.segment &&
          visits[loop.candidate].segment < join.segment) {
        const double seconds = std::max(0.0, SecondsBetween(join.seen_ns, loop.believed_ns));
        join.joined_after_seconds = std::min(join.joined_after_seconds.value_or(seconds), seconds);
      }
    }
  }
  return joins;
}

}  // namespace

void LoopEvaluationOptions::Validate() const {
  CheckPositive(max_distance_m, "loop_evaluation.max_distance_m");
  CheckWithin(max_angle_deg, 0.0, 180.0, "loop_evaluation.max_angle_deg");
  CheckWithin(min_age_s, 0.0, 1e9, "loop_evaluation.min_age_s");
  CheckPositive(right_m, "loop_evaluation.right_m");
  CheckWithin(right_deg, 0.0, 180.0, "loop_evaluation.right_deg");
  CheckPositive(max_time_difference_s, "loop_evaluation.max_time_difference_s");
}

LoopEvaluation EvaluateLoops(const std::vector<PlaceVisit>& visits,
                             const std::vector<BelievedLoop>& loops, const Trajectory& groundtruth,
                             const LoopEvaluationOptions& options) {
  options.Validate();
  Truths truths;
  truths.reserve(visits.size());
  for (const PlaceVisit& visit : visits) {
    truths.push_back(TruthAt(groundtruth, visit.timestamp_ns, options.max_time_difference_s));
  }
  std::vector<bool> is_known(visits.size(), false);
  LoopEvaluation evaluation;
  for (const BelievedLoop& loop : loops) {
    if (loop.candidate >= visits.size() || loop.query >= visits.size()) {
      throw Error("a loop between visits " + std::to_string(loop.candidate) + " and " +
                  std::to_string(loop.query) + " of " + std::to_string(visits.size()));
    }
    if (!truths[loop.candidate] || !truths[loop.query]) {
      continue;
    }
    const Rigid3 truth = truths[loop.candidate]->Inverse() * *truths[loop.query];
    ++evaluation.loops;
    if (IsWithin(truth.Inverse() * loop.candidate_from_query, options.right_m, options.right_deg)) {
      is_known[loop.query] = true;
    } else {
      ++evaluation.wrong;
      evaluation.wrong_kept +=
          IsWithin(loop.candidate_from_query_kept.Inverse() * loop.candidate_from_query,
                   options.right_m, options.right_deg);
    }
  }
  const std::vector<bool> revisits = Revisits(visits, truths, options);
  for (std::size_t i = 0; i < visits.size(); ++i) {
    evaluation.revisits += revisits[i];
    evaluation.found += revisits[i] && is_known[i];
  }
  if (evaluation.revisits > 0) {
    evaluation.recall =
        static_cast<double>(evaluation.found) / static_cast<double>(evaluation.revisits);
  }
  if (evaluation.loops > 0) {
    evaluation.precision =
        1.0 - static_cast<double>(evaluation.wrong) / static_cast<double>(evaluation.loops);
  }
  evaluation.joins = Joins(visits, loops, truths, options);
  return evaluation;
}

}  // namespace gluevo::vo
