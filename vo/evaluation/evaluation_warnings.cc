#include <cmath>
#include <sstream>

#include "gluevo/vo/evaluation/evaluation.h"

namespace gluevo::vo {

std::optional<std::string> AssociationWarning(const Evaluation& evaluation,
                                              const EvaluationOptions& options) {
  const bool estimate_is_longer = evaluation.estimate_poses > evaluation.groundtruth_poses;
  const bool truth_has_few_mates =
      estimate_is_longer && 2 * evaluation.pairs < evaluation.groundtruth_poses;
  const std::size_t poses =
      truth_has_few_mates ? evaluation.groundtruth_poses : evaluation.estimate_poses;
  if (2 * evaluation.pairs >= poses) {
    return std::nullopt;
  }
  std::ostringstream text;
  text << "only " << evaluation.pairs << " of " << poses << " poses of the "
       << (truth_has_few_mates ? "ground truth" : "estimate") << " have a mate in the "
       << (truth_has_few_mates ? "estimate" : "ground truth") << " within "
       << options.max_time_difference_s << " s: the figures are of these few";
  return text.str();
}

std::optional<std::string> ScaleWarning(const Evaluation& evaluation) {
  constexpr double kOdd = 10.0;
  const bool truth_is_larger = evaluation.scale > 1.0;
  const double ratio = truth_is_larger ? evaluation.scale : 1.0 / evaluation.scale;
  if (!std::isfinite(ratio) || !(ratio > kOdd)) {
    return std::nullopt;
  }
  const auto near = [&](double value) { return std::abs(std::log(ratio / value)) < 0.2; };
  const std::string larger = truth_is_larger ? "ground truth" : "estimate";
  std::ostringstream text;
  text.precision(4);
  text << "the " << larger << " is " << ratio << " times as large as the "
       << (truth_is_larger ? "estimate" : "ground truth") << ": ";
  if (near(1000.0) || near(100.0)) {
    text << "is the " << larger << " in " << (near(1000.0) ? "millimetres" : "centimetres")
         << ", not in metres?";
  } else {
    text << "are both in metres?";
  }
  return text.str();
}

}  // namespace gluevo::vo
