#pragma once

namespace gluevo::vo {

/// How far keypoints may be from where they belong: sharp images and large ones deserve less than
/// small blurred ones.
struct KeypointNoiseOptions {
  /// What the frames say is taken within these, pixels (of kReferenceFocalPx). Equal ones fix it.
  double least_px = 0.8;
  double largest_px = 3.0;
  /// Times what they say. A view within 99 of 100 is kept, so that without a margin every tenth
  /// track of ten right views would end.
  double margin = 1.4;
  /// How much a frame's say counts beside those before it, 0 to 1.
  double share = 0.3;

  /// Throws Error naming the option.
  void Validate() const;
};

/// The standard deviation to allow keypoints, from how well poses explain the frames so far. By
/// medians, so that things that move and wrong matches weigh little while they are less than half.
class KeypointNoise {
 public:
  /// `start_px`: until frames say more.
  KeypointNoise(double start_px, const KeypointNoiseOptions& options);

  /// Pixels of kReferenceFocalPx.
  double px() const { return px_; }
  /// `median_error_px`: as in PnpResult.
  void Learn(double median_error_px);

 private:
  KeypointNoiseOptions options_;
  double px_;
};

}  // namespace gluevo::vo
