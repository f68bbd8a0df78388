#include "evaluation_json.h"

#include <cmath>

namespace gluevo::apps {

using Json = nlohmann::ordered_json;

Json FiniteOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

void AddEvaluation(const vo::Evaluation& evaluation, Json& json) {
  json["pairs"] = evaluation.pairs;
  json["estimate_poses"] = evaluation.estimate_poses;
  json["groundtruth_poses"] = evaluation.groundtruth_poses;
  json["ate_se3_m"] = FiniteOrNull(evaluation.ate_se3_m);
  json["ate_sim3_m"] = FiniteOrNull(evaluation.ate_sim3_m);
  json["scale"] = FiniteOrNull(evaluation.scale);
  json["rpe_translation_percent"] = FiniteOrNull(evaluation.rpe_translation_percent);
  json["rpe_rotation_deg_per_m"] = FiniteOrNull(evaluation.rpe_rotation_deg_per_m);
  json["rpe_lengths_m"] = evaluation.rpe_lengths_m;
  json["rpe_frames_translation_m"] = FiniteOrNull(evaluation.rpe_frames_translation_m);
  json["rpe_frames_translation_median_m"] =
      FiniteOrNull(evaluation.rpe_frames_translation_median_m);
  json["rpe_frames_rotation_deg"] = FiniteOrNull(evaluation.rpe_frames_rotation_deg);
  json["motions"] = evaluation.pairs - 1;
  json["correct_motions"] = evaluation.correct_motions;
  json["coverage"] = FiniteOrNull(evaluation.coverage);
}

void AddSegmentedEvaluation(const vo::SegmentedEvaluation& evaluation, Json& json) {
  Json within;
  within["ate_se3_m"] = FiniteOrNull(evaluation.ate_within_segments_m);
  within["pairs"] = evaluation.pairs_within_segments;
  within["motions"] = evaluation.motions;
  within["correct_motions"] = evaluation.correct_motions;
  within["breaks"] = evaluation.breaks;
  within["segments"] = Json::array();
  for (const vo::SegmentedEvaluation::Segment& segment : evaluation.segments) {
    Json entry = {{"number", segment.number}, {"pairs", segment.pairs}};
    if (segment.evaluation) {
      entry["ate_se3_m"] = FiniteOrNull(segment.evaluation->ate_se3_m);
      entry["ate_sim3_m"] = FiniteOrNull(segment.evaluation->ate_sim3_m);
      entry["scale"] = FiniteOrNull(segment.evaluation->scale);
    }
    within["segments"].push_back(entry);
  }
  json["within_segments"] = within;
}

}  // namespace gluevo::apps
