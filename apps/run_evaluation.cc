#include "run_evaluation.h"

#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/evaluation/evaluation.h"

namespace gluevo::apps {

void AddEvaluations(const vo::Dataset& dataset, const RunRecords& records,
                    RunMetrics::Context& context) {
  if (!dataset.groundtruth) {
    return;
  }
  const vo::Trajectory& groundtruth = *dataset.groundtruth;
  try {
    context.evaluation = vo::Evaluate(records.trajectory, groundtruth, {});
    context.evaluation_warning = vo::AssociationWarning(*context.evaluation, {}).value_or("");
    if (const auto warning = vo::ScaleWarning(*context.evaluation)) {
      context.evaluation_warning += (context.evaluation_warning.empty() ? "" : "; ") + *warning;
    }
    context.segmented_evaluation = vo::EvaluateSegments(
        records.trajectory, records.metrics.SegmentOfFrames(), groundtruth, {});
  } catch (const Error& error) {
    context.evaluation_failure = error.what();
  }
}

}  // namespace gluevo::apps
