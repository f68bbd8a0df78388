#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "chart.h"
#include "run_report.h"

namespace gluevo::apps {

/// A count of every frame over time, broken where tracking was lost.
Series CountSeries(const RunReport& report, const std::string& name, const std::string& style,
                   int vo::FrameResult::*count);

/// How far off each frame's position may be, metres: the square root of the sum of its path
/// covariance's variances, which is one standard deviation; broken where tracking was lost.
Series PositionSigmaSeries(const RunReport& report, const std::string& style);

/// Times of a stage over the frames' times.
Series StageSeries(const RunReport& report, const std::string& name, const std::string& style,
                   const std::string& stage);

/// Where tracking was lost, for charts over time.
std::vector<ChartMark> ResetMarks(const RunReport& report);

/// Indices of the evaluation's errors whose poses belong to another segment than the one before.
/// The report must have an evaluation.
std::vector<std::size_t> ErrorBreaks(const RunReport& report);

/// Times of the key frames, seconds from the first frame.
std::vector<double> KeyframeTimes(const RunReport& report);

/// Value below which the share `q` of the values lies (nearest rank); 0 of none.
double Quantile(std::vector<double> values, double q);

}  // namespace gluevo::apps
