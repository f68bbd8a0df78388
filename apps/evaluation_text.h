#pragma once

#include <string>

#include "gluevo/vo/evaluation/evaluation.h"

// Figures of an evaluation for people: where one is not defined they read why, and no "nan".
namespace gluevo::apps {

/// The relative pose error over sub-paths in two figures ("0.652 %" and "0.0116 deg/m"), or why
/// there is none (the same for both).
struct RpeText {
  std::string translation;
  std::string rotation;
  bool is_known = false;
};
RpeText TextOfRpe(const vo::Evaluation& evaluation, int percent_decimals, int degree_decimals);

/// Those of its sub-paths that the path holds: "10, 20, 30 m".
std::string TextOfRpeLengths(const vo::Evaluation& evaluation);

/// The same over frames: "0.012300 m, 0.045000 deg; median 0.010200 m".
std::string TextOfRpeOverFrames(const vo::Evaluation& evaluation, int decimals);

/// "1.0036", or why there is none.
std::string TextOfScale(const vo::Evaluation& evaluation, int decimals);

}  // namespace gluevo::apps
