#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/nn/gray_image.h"
#include "gluevo/nn/isa.h"
#include "gluevo/nn/tensor.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/workspace.h"

namespace gluevo::nn {

namespace kernels {
struct BlockedMap;
struct Kernels;
}  // namespace kernels

struct SuperPointOptions {
  /// Keypoints have a score above this, 0 to 1.
  float keypoint_threshold = 0.005F;
  /// Radius in pixels of non-maximum suppression.
  int nms_radius = 4;
  /// Keypoints closer than this to the border of the score map are dropped, pixels.
  int border = 4;
  /// The best so many are kept.
  int max_keypoints = 1024;
  /// Move each keypoint off its pixel to the peak of the parabola through the logarithms of its and
  /// its neighbours' scores, at most half a pixel on each axis. Not in the paper.
  bool subpixel = false;

  /// Throws Error naming the field that is out of range.
  void Validate() const;
};

/// SuperPoint (DeTone, Malisiewicz and Rabinovich 2018): keypoints and descriptors of an image. The
/// widths of all layers are those of the weights; sides of an image that are no multiple of 8 lose
/// their last rows or columns to the pooling, as in the published code. A layer may have a batch
/// normalisation after its activation: tensors `conv1a.scale` and `conv1a.shift` and so on, one
/// value for each output channel.
class SuperPoint {
 public:
  /// Both views live in the workspace until its next use.
  struct DenseMaps {
    TensorView<float> scores;       ///< [8 h x 8 w]: keypoint probability of each pixel.
    TensorView<float> descriptors;  ///< [h x w x D]: of each 8 x 8 cell, unit length.
  };

  /// Throws Error naming the file and the tensor for weights that are not a SuperPoint's.
  explicit SuperPoint(const Weights& weights, Isa isa = ChooseIsa());
  SuperPoint(SuperPoint&&) noexcept;
  SuperPoint& operator=(SuperPoint&&) noexcept;
  ~SuperPoint();

  /// D, 256 in all published forms.
  int descriptor_size() const { return descriptor_size_; }

  /// Floating-point operations of both dense maps, as published: a direct convolution's two for
  /// each multiply-add, nothing else. Extract and Describe do with fewer.
  double Flops(int width, int height) const;

  /// Throws Error for an image smaller than 8 x 8 pixels.
  DenseMaps Dense(const GrayImage& image, Workspace& workspace) const;

  /// Keypoints in order of falling score, with their descriptors. Throws Error for bad options or
  /// an image smaller than 8 x 8 pixels.
  void Extract(const GrayImage& image, const SuperPointOptions& options, Workspace& workspace,
               Features& features) const;

  /// Descriptors at given positions: fills `features.descriptors` for the `features.keypoints` (N x
  /// 2, pixels) that are there; positions outside the image get the nearest cell's. Finds no
  /// keypoints and has no scores for these: `features.scores` becomes empty.
  void Describe(const GrayImage& image, Workspace& workspace, Features& features) const;

 private:
  struct Convolution;
  struct Head;
  struct Layers;
  struct Buffers;
  enum class Heads { kBoth, kDescriptor };

  // Buffers for the trunk and for `heads`, which are those that may be run on its output.
  kernels::BlockedMap Trunk(const GrayImage& image, Heads heads, Workspace& workspace,
                            Buffers& buffers) const;
  kernels::BlockedMap FirstLayers(const GrayImage& image, Workspace& workspace,
                                  const Buffers& buffers) const;
  void Convolve(const Convolution& layer, const kernels::BlockedMap& in,
                const kernels::BlockedMap& out, Workspace& workspace, const Buffers& buffers) const;
  // A 1x1 convolution of pixels in blocks of channels, to rows of floats.
  void Project(const Convolution& layer, const float* pixels, int64_t block_stride, int64_t count,
               float* out, int64_t out_stride) const;
  // [8 h x 8 w]
  TensorView<float> Scores(const kernels::BlockedMap& trunk, Workspace& workspace,
                           const Buffers& buffers) const;
  void DescribeAt(const kernels::BlockedMap& trunk, Workspace& workspace, const Buffers& buffers,
                  Features& features) const;

  const kernels::Kernels* kernels_;
  std::unique_ptr<const Layers> layers_;
  int descriptor_size_ = 0;
};

/// The score map's keypoints (row * width + column, in order of falling score, equal ones in order
/// of position): non-maximum suppression as published (repeated max-pooling with two extra passes,
/// so that points freed by a suppressed neighbour come back), then threshold, border and the best
/// max_keypoints. `scores` [height x width].
void SelectKeypoints(TensorView<const float> scores, const SuperPointOptions& options,
                     Workspace& workspace, std::vector<int64_t>& keypoints);

/// Descriptors [N x D] at keypoints [N x 2] by bilinear interpolation of the dense map [h x w x D]
/// and normalisation to unit length: the published sampling, which puts keypoint k of an image at
/// ((k - 3.5) / (8 s - 4.5)) (s - 1) of a map with side s.
void SampleDescriptors(TensorView<const float> map, const Features::Points& keypoints,
                       Features::RowMajor& descriptors);

}  // namespace gluevo::nn
