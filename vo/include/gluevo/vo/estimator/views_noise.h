#pragma once

namespace gluevo::vo {

/// How noisy the views are, in shares of the noise that the window divides their residuals by. To
/// the views alone it does not matter; beside readings of another sensor, whose noise is known, it
/// says what each is worth.
class ViewsNoise {
 public:
  /// A window's mean square of residuals, and how many more of them than unknowns there were.
  void Learn(double mean_square, double freedom);
  /// The noise over that which is assumed.
  double Factor() const;

 private:
  double mean_square_ = 1.0;
  int windows_ = 0;
};

}  // namespace gluevo::vo
