#include "aliked_layers.h"

#include <algorithm>

#include "kernels/winograd.h"

namespace gluevo::nn {
namespace {

using kernels::BlocksOf;
using kernels::kBlock;

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int64_t kTaps = 9;

Tensor<float> PaddedBias(const Affine& affine) {
  Tensor<float> bias({PaddedChannels<float>(affine.bias.size())});
  bias.view().Vector().head(affine.bias.size()) = affine.bias.cast<float>();
  return bias;
}

AlikedLayers::Convolution Pack(const Affine& affine, void (*kernel)(const kernels::Conv3x3&),
                               int64_t (*floats_of)(int64_t, int64_t),
                               void (*pack)(const float*, int64_t, int64_t, float*)) {
  const int64_t out = affine.weight.rows();
  const int64_t in = affine.weight.cols() / kTaps;
  const RowMajor weight = affine.weight.cast<float>();
  AlikedLayers::Convolution packed;
  packed.kernel = kernel;
  packed.weights = Tensor<float>({floats_of(out, in)});
  pack(weight.data(), out, in, packed.weights.data());
  packed.bias = PaddedBias(affine);
  return packed;
}

AlikedLayers::Convolution PackDirect(const Affine& affine, const kernels::Kernels& kernels) {
  return Pack(affine, kernels.conv3x3, kernels::PackedConv3x3Floats, kernels::PackConv3x3);
}

AlikedLayers::Convolution PackForRegions(const Affine& affine, const kernels::Kernels& kernels) {
  return kernels.winograd3x3 == nullptr
             ? PackDirect(affine, kernels)
             : Pack(affine, kernels.winograd3x3, kernels::PackedWinograd3x3Floats,
                    kernels::PackWinograd3x3);
}

// Columns (channel, tap) to (tap, channel), each tap in whole blocks, and then those of `shortcut`.
Affine TapMajor(const Affine& affine, const Affine& shortcut) {
  const int64_t in = affine.weight.cols() / kTaps;
  const int64_t padded = PaddedChannels<float>(in);
  Affine result;
  result.weight.setZero(affine.weight.rows(), kTaps * padded + shortcut.weight.cols());
  result.bias = affine.bias;
  for (int64_t tap = 0; tap < kTaps; ++tap) {
    for (int64_t channel = 0; channel < in; ++channel) {
      result.weight.col(tap * padded + channel) = affine.weight.col(channel * kTaps + tap);
    }
  }
  if (shortcut.weight.size() > 0) {
    result.weight.rightCols(shortcut.weight.cols()) = shortcut.weight;
  }
  return result;
}

// What is to be packed, in the order in which it is used.
struct Products {
  Affine downsample;
  std::array<std::array<Affine, 2>, 2> deformable;
  Affine offsets_hidden;
};

Products MakeProducts(const AlikedWeights& weights) {
  Products products;
  products.downsample = weights.blocks[1].downsample;
  products.downsample.bias = Eigen::VectorXd::Zero(products.downsample.weight.rows());
  for (std::size_t i = 0; i < 2; ++i) {
    const AlikedWeights::Block& block = weights.blocks[2 + i];
    products.deformable[i] = {TapMajor(block.conv1, {}), TapMajor(block.conv2, block.downsample)};
  }
  products.offsets_hidden = TapMajor(weights.offsets_hidden, {});
  return products;
}

}  // namespace

AlikedLayers::AlikedLayers(const AlikedWeights& weights, const kernels::Kernels& kernels)
    : widths(weights.widths),
      size(weights.size),
      samples(weights.samples),
      block1_conv1(PackDirect(weights.blocks[0].conv1, kernels)),
      block1_conv2(PackForRegions(weights.blocks[0].conv2, kernels)),
      block2_conv1(PackForRegions(weights.blocks[1].conv1, kernels)),
      block2_conv2(PackForRegions(weights.blocks[1].conv2, kernels)),
      score_channels(weights.score_groups[0].weight.rows()),
      score_layers(weights.score_layers) {
  const Products products = MakeProducts(weights);
  std::vector<std::pair<const Affine*, Linear<float>*>> list = {
      {&products.downsample, &block2_downsample}};
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t conv = 0; conv < 2; ++conv) {
      list.emplace_back(&products.deformable[i][conv], &deformable[i][conv].values);
    }
    const AlikedWeights::Block& block = weights.blocks[2 + i];
    deformable[i][0].offsets = PackDirect(block.offsets1, kernels);
    deformable[i][1].offsets = PackDirect(block.offsets2, kernels);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    list.emplace_back(&weights.projections[i], &projections[i]);
    list.emplace_back(&weights.score_groups[i], &score_groups[i]);
  }
  list.emplace_back(&products.offsets_hidden, &offsets_hidden);
  list.emplace_back(&weights.offsets_out, &offsets_out);
  list.emplace_back(&weights.sample_features, &sample_features);
  list.emplace_back(&weights.aggregation, &aggregation);

  int64_t room = 0;
  for (const auto& [affine, linear] : list) {
    room += kernels::PackedMatrixSize<float>(affine->weight.rows(), affine->weight.cols());
  }
  storage_ = Tensor<float>({room});
  Packer<float> packer(storage_);
  for (const auto& [affine, linear] : list) {
    *linear = packer.Pack(*affine, PaddedChannels<float>(affine->weight.rows()));
  }
  for (std::size_t i = 0; i < 2; ++i) {
    Linear<float>& second = deformable[i][1].values;
    second.blocks1 = BlocksOf(widths[1 + i]);
    second.blocks0 -= second.blocks1;
  }
}

}  // namespace gluevo::nn
