#pragma once

#include "gluevo/vo/io/dataset.h"
#include "run_frames.h"
#include "run_metrics.h"

namespace gluevo::apps {

/// Where the data set has ground truth: what the run's trajectory is worth, as a whole and segment
/// by segment, or why that cannot be said.
void AddEvaluations(const vo::Dataset& dataset, const RunRecords& records,
                    RunMetrics::Context& context);

}  // namespace gluevo::apps
