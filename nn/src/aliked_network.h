#pragma once

#include <array>
#include <cstdint>

#include "aliked_layers.h"
#include "gluevo/nn/aliked.h"
#include "gluevo/nn/features.h"
#include "gluevo/nn/gray_image.h"
#include "gluevo/nn/workspace.h"
#include "kernels/kernels.h"
#include "kernels/open_kernels.h"

namespace gluevo::nn {

/// What the encoder makes of an image; all of it is in an arena. Maps 0 to 3 have the padded
/// image's size over 1, 2, 8 and 32.
struct AlikedMaps {
  int64_t width = 0;  ///< Of the image; it lies in the padded one from (left, top) on.
  int64_t height = 0;
  int64_t padded_width = 0;
  int64_t padded_height = 0;
  int64_t left = 0;
  int64_t top = 0;
  std::array<kernels::BlockedMap, 4> blocks;    ///< Outputs of the blocks.
  std::array<kernels::BlockedMap, 4> features;  ///< Projections of these; none of block 1.
  /// Their part of the score head's first layer; that of block 1 is [padded height][padded width]
  /// [ScoreStride], and null where no scores are wanted.
  std::array<kernels::BlockedMap, 4> scores;
  TensorView<float> fine_scores;
  std::array<kernels::BlockedMap, 2> offsets;  ///< Of the first convolutions of blocks 3 and 4.
  /// How the maps 1 to 3 are interpolated at each row and column of the padded image.
  std::array<kernels::AlignedTap*, 3> taps_y;
  std::array<kernels::AlignedTap*, 3> taps_x;
};

/// ALIKED (Zhao et al. 2023), but for the choice of keypoints. The feature map at full size, a
/// hundred channels and more, is never built: its part in the score head is linear up to the first
/// activation, as is its interpolation, so the score head's first layer is applied to the coarse
/// maps; and descriptors need it at less than a tenth of the pixels.
class AlikedNetwork {
 public:
  AlikedNetwork(const AlikedWeights& weights, Isa isa)
      : kernels_(&kernels::KernelsFor(isa)),
        open_(&kernels::OpenKernelsFor(isa)),
        layers_(weights, *kernels_) {}

  const AlikedLayers& layers() const { return layers_; }

  /// Scores are wanted only of images whose keypoints are. At least 8 x 8 pixels.
  AlikedMaps Encode(const GrayImage& image, bool with_scores, Workspace& workspace) const;

  /// [height x width]
  TensorView<float> Scores(const AlikedMaps& maps, Workspace& workspace) const;

  /// Of features.keypoints.
  void Describe(const AlikedMaps& maps, Workspace& workspace, Features& features) const;

  /// Features of single pixels of the padded image, unit length: rows in blocks, as FeatureRows
  /// writes them; `rows` has got the rows, their stride and number, and the pixels. `scratch`:
  /// BlocksOf(widths[0]) * kBlock floats a row.
  void FeaturesAt(const AlikedMaps& maps, kernels::FeatureRows rows, float* scratch) const;

 private:
  struct Buffers;
  struct Region;
  struct DescriptorScratch;
  struct PointBand;

  void SeluRegion(const kernels::BlockedMap& map, const Region& region) const;
  // From a row of a block's output to its features, where the map has them, and scores.
  void ProjectRow(int level, int64_t y, int64_t x, int64_t count, const AlikedMaps& maps,
                  float* scratch) const;
  void Block1(float* gray, const AlikedMaps& maps, const Buffers& buffers,
              Workspace& workspace) const;
  void Block2(const AlikedMaps& maps, const Buffers& buffers, Workspace& workspace) const;
  void DeformableBlock(int level, const AlikedMaps& maps, const Buffers& buffers,
                       Workspace& workspace) const;
  // in -> out by convolution `conv` (0 or 1) of block `level`; `shortcut` of the second one.
  void DeformableConvolution(int level, int conv, const kernels::BlockedMap& in,
                             const kernels::BlockedMap& offsets,
                             const kernels::BlockedMap& shortcut, const kernels::BlockedMap& out,
                             Workspace& workspace) const;
  // Of all samples of the band, in blocks; from patches of features around the keypoints.
  const float* PredictOffsets(const AlikedMaps& maps, const PointBand& band,
                              const DescriptorScratch& scratch) const;
  // Features between the pixels around one sample of each keypoint.
  void SampleFeatures(const AlikedMaps& maps, const PointBand& band, int64_t sample,
                      const float* offsets, const DescriptorScratch& scratch) const;
  void DescribeBand(const AlikedMaps& maps, const PointBand& band, const DescriptorScratch& scratch,
                    float* descriptors) const;

  const kernels::Kernels* kernels_;
  const kernels::OpenKernels* open_;
  AlikedLayers layers_;
};

}  // namespace gluevo::nn
