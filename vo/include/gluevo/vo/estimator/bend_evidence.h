#pragma once

#include <array>

namespace gluevo::vo {

/// Whether what looks like a turn of the right camera is one (StereoCorrection). A turned camera
/// bends its image by the turn's second order, once. Lenses bend what the calibration left of them,
/// by any amount: where views ask for more, that is what they see, and a turn that follows them
/// makes near points, which are at the border, too near or too far. Told by what bundle adjustments
/// of the same views cost.
class BendEvidence {
 public:
  /// Of StereoCorrection; those whose costs are compared.
  static constexpr std::array<double, 2> kBends = {1.0, 2.0};

  /// Half the sums of squares of one window, in standard deviations, in the order of kBends.
  void Add(const std::array<double, 2>& costs);
  bool has_begun() const { return windows_ > 0; }
  /// Enough windows to leave it at that.
  bool is_complete() const { return windows_ == kWindows; }
  /// 1 until the views of all windows together surely ask for more, then 0.
  double Bend() const;

 private:
  static constexpr int kWindows = 10;

  double gain_ = 0.0;  ///< Of the larger bend.
  int windows_ = 0;
};

}  // namespace gluevo::vo
