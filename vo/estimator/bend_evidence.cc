#include "gluevo/vo/estimator/bend_evidence.h"

namespace gluevo::vo {

void BendEvidence::Add(const std::array<double, 2>& costs) {
  gain_ += costs[0] - costs[1];
  ++windows_;
}

double BendEvidence::Bend() const {
  // Were 1 the truth, the gain would be negative but for noise: this is three standard deviations
  // of it where both fit alike.
  constexpr double kSureGain = 0.5 * 3.0 * 3.0;
  return gain_ > kSureGain ? 0.0 : 1.0;
}

}  // namespace gluevo::vo
