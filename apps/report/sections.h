#pragma once

#include <string>

#include "run_report.h"

namespace gluevo::apps {

/// The parts of a run's page, each an HTML fragment. Where a part needs ground truth and there is
/// none, it says so.

/// What run it was and its figures: the first screen.
std::string VerdictSection(const RunReport& report);
/// From above and from the side, over the ground truth, aligned by SE(3) and by Sim(3) (Yoon and
/// Park, figures 2 and 4).
std::string TrajectorySection(const RunReport& report);
/// Error over time and along the path.
std::string ErrorSection(const RunReport& report);
/// The path before and after loops, with lines between the places that were taken for one; empty
/// where the run looked for none.
std::string LoopsSection(const RunReport& report);
/// Matches a frame, key frames, segments.
std::string MatchesSection(const RunReport& report);
/// Biases, gravity and residuals of the inertial unit; empty where the run used none.
std::string InertialSection(const RunReport& report);
std::string TimesSection(const RunReport& report);
std::string StripSection(const RunReport& report);
/// Options, weights, machine.
std::string RecordSection(const RunReport& report);

/// Seconds from the first frame.
double SecondsIn(const RunReport& report, int64_t timestamp_ns);

/// A line that says why a part that needs ground truth is empty.
std::string NoGroundTruth(const RunReport& report);

}  // namespace gluevo::apps
