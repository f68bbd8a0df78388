#pragma once

#include <nlohmann/json.hpp>

#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/evaluation/segment_evaluation.h"

namespace gluevo::apps {

/// Null where a figure is not defined: JSON has no NaN.
nlohmann::ordered_json FiniteOrNull(double value);

/// Adds an evaluation's figures to an object, under the names that metrics.json and
/// `gluevo evaluate --json` share.
void AddEvaluation(const vo::Evaluation& evaluation, nlohmann::ordered_json& json);

/// Adds `within_segments`, what is left when poses of different segments are not compared.
void AddSegmentedEvaluation(const vo::SegmentedEvaluation& evaluation,
                            nlohmann::ordered_json& json);

}  // namespace gluevo::apps
