#pragma once

#include <cstdint>
#include <memory>

#include "gluevo/nn/features.h"
#include "gluevo/nn/gray_image.h"
#include "gluevo/nn/isa.h"
#include "gluevo/nn/tensor.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/workspace.h"

namespace gluevo::nn {

class AlikedNetwork;

struct AlikedOptions {
  /// Keypoints have a peak of the score map above this, 0 to 1.
  float keypoint_threshold = 0.2F;
  /// The best so many are kept.
  int max_keypoints = 1024;

  /// Throws Error naming the field that is out of range.
  void Validate() const;
};

/// ALIKED (Zhao et al. 2023): keypoints at fractions of a pixel and descriptors of an image, from
/// deformable convolutions; widths, descriptor size and number of sample positions are those of the
/// weights. Its three colours are the same gray here. Images are padded to multiples of 32 pixels
/// by their borders, as in the published code; where no peak passes the threshold there are no
/// keypoints (the published code lowers it then).
class Aliked {
 public:
  /// Throws Error naming the file and the tensor for weights that are not an ALIKED's.
  explicit Aliked(const Weights& weights, Isa isa = ChooseIsa());
  Aliked(Aliked&&) noexcept;
  Aliked& operator=(Aliked&&) noexcept;
  ~Aliked();

  /// 64 for t16, else 128.
  int descriptor_size() const;

  /// Floating-point operations for so many keypoints, as published: two for each multiply-add of
  /// convolutions and products, of a gray image's first layer a third. Fewer are done.
  double Flops(int width, int height, int keypoints) const;

  /// [height x width]: of each pixel, how good a keypoint it is, 0 to 1. Lives in the workspace
  /// until its next use. Throws Error for an image smaller than 8 x 8 pixels.
  TensorView<float> Scores(const GrayImage& image, Workspace& workspace) const;

  /// Keypoints in order of falling peaks, with their descriptors. (Their scores are those of the
  /// score map at the refined positions, so they do not quite fall.) Throws Error for bad options
  /// or an image smaller than 8 x 8 pixels.
  void Extract(const GrayImage& image, const AlikedOptions& options, Workspace& workspace,
               Features& features) const;

  /// Descriptors at given positions: fills `features.descriptors` for the `features.keypoints` (N x
  /// 2, pixels) that are there. Finds no keypoints and has no scores for these: `features.scores`
  /// becomes empty.
  void Describe(const GrayImage& image, Workspace& workspace, Features& features) const;

 private:
  std::unique_ptr<const AlikedNetwork> network_;
};

}  // namespace gluevo::nn
