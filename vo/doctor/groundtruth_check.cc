#include <algorithm>

#include "checks.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::vo {

Findings CheckGroundtruth(const std::optional<Trajectory>& groundtruth,
                          const std::vector<int64_t>& times_ns) {
  if (!groundtruth || groundtruth->empty()) {
    return {{Verdict::kGood, "ground truth", "none found: a run prints no errors", ""}};
  }
  // As in evaluations.
  constexpr int64_t kNear = 10'000'000;
  std::size_t covered = 0;
  for (const int64_t time : times_ns) {
    const auto after = std::lower_bound(
        groundtruth->begin(), groundtruth->end(), time - kNear,
        [](const StampedPose& pose, int64_t limit) { return pose.timestamp_ns < limit; });
    covered += after != groundtruth->end() && after->timestamp_ns <= time + kNear ? 1 : 0;
  }
  const double share = times_ns.empty() ? 0.0
                                        : 100.0 * static_cast<double>(covered) /
                                              static_cast<double>(times_ns.size());
  constexpr double kMost = 50.0;
  Findings findings;
  findings.push_back({share >= kMost ? Verdict::kGood
                      : share > 0.0  ? Verdict::kSuspicious
                                     : Verdict::kWrong,
                      "ground truth",
                      std::to_string(groundtruth->size()) + " poses, " + FixedText(share, 0) +
                          " % of the frames have one within 0.01 s",
                      "half of them: are both of one clock and unit?"});
  double length = 0.0;
  for (std::size_t i = 1; i < groundtruth->size(); ++i) {
    length += ((*groundtruth)[i].world_from_body.translation -
               (*groundtruth)[i - 1].world_from_body.translation)
                  .norm();
  }
  const double duration = 1e-9 * static_cast<double>(groundtruth->back().timestamp_ns -
                                                     groundtruth->front().timestamp_ns);
  const double speed = duration > 0.0 ? length / duration : 0.0;
  // Cars drive up to 50 m/s; a thousandth of a walk is a unit.
  constexpr double kFastest = 60.0;
  findings.push_back({UpTo(speed, kFastest, 300.0), "speed of the ground truth",
                      FixedText(speed, 2) + " m/s over " + FixedText(length, 1) + " m",
                      "up to 60 m/s: is it in metres?"});
  return findings;
}

}  // namespace gluevo::vo
