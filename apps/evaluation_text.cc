#include "evaluation_text.h"

#include <cmath>

#include "gluevo/vo/core/text.h"

namespace gluevo::apps {
RpeText TextOfRpe(const vo::Evaluation& evaluation, int percent_decimals, int degree_decimals) {
  if (!std::isfinite(evaluation.rpe_translation_percent)) {
    const std::string why = evaluation.path_m > 0.0
                                ? "none: the ground truth's path of " +
                                      vo::ShortText(evaluation.path_m, 3) +
                                      " m is too short, expected more than " +
                                      vo::ShortText(evaluation.shortest_path_m) + " m"
                                : "none: the ground truth does not move";
    return {why, why, false};
  }
  return {vo::FixedText(evaluation.rpe_translation_percent, percent_decimals) + " %",
          vo::FixedText(evaluation.rpe_rotation_deg_per_m, degree_decimals) + " deg/m", true};
}

std::string TextOfRpeLengths(const vo::Evaluation& evaluation) {
  std::string lengths;
  for (const double length : evaluation.rpe_lengths_m) {
    lengths += (lengths.empty() ? "" : ", ") + vo::ShortText(length);
  }
  return lengths.empty() ? "none" : lengths + " m";
}

std::string TextOfRpeOverFrames(const vo::Evaluation& evaluation, int decimals) {
  if (!std::isfinite(evaluation.rpe_frames_translation_m)) {
    return "none: fewer poses than that associate";
  }
  return vo::FixedText(evaluation.rpe_frames_translation_m, decimals) + " m, " +
         vo::FixedText(evaluation.rpe_frames_rotation_deg, decimals) + " deg; median " +
         vo::FixedText(evaluation.rpe_frames_translation_median_m, decimals) + " m";
}

std::string TextOfScale(const vo::Evaluation& evaluation, int decimals) {
  return std::isfinite(evaluation.scale) ? vo::FixedText(evaluation.scale, decimals)
                                         : "none: one of both does not move";
}

}  // namespace gluevo::apps
