// LightGlue's adaptive depth and width (Lindenberger et al. 2023, section 3.3), by the rules of the
// published code.

#include <algorithm>
#include <cmath>

#include "lightglue_network.h"

namespace gluevo::nn {
namespace {

using kernels::BlocksOf;
using kernels::kBlock;

float Sigmoid(float x) { return 1.0F / (1.0F + std::exp(-x)); }

}  // namespace

float LightGlueNetwork::ConfidenceThreshold(int64_t layer) const {
  const auto layers = static_cast<double>(layers_.layers.size());
  const double threshold = 0.8 + 0.1 * std::exp(-4.0 * static_cast<double>(layer) / layers);
  return static_cast<float>(std::clamp(threshold, 0.0, 1.0));
}

bool LightGlueNetwork::StopsAfter(int64_t layer, const LightGlueOptions& options,
                                  const LightGlueState& state) const {
  const float threshold = ConfidenceThreshold(layer);
  int64_t unsure = 0;
  int64_t all = 0;  // Keypoints that have left count as sure.
  for (const LightGlueImage& image : state.images) {
    all += image.features->size();
    for (int64_t i = 0; i < image.count; ++i) {
      unsure += Sigmoid(image.logits[i * kBlock + 1]) < threshold ? 1 : 0;
    }
  }
  return 1.0 - static_cast<double>(unsure) / static_cast<double>(all) > options.depth_confidence;
}

void LightGlueNetwork::Prune(int64_t layer, const LightGlueOptions& options,
                             LightGlueImage& image) const {
  const float confidence_threshold = ConfidenceThreshold(layer);
  const float least = 1.0F - options.width_confidence;
  const auto move_row = [&](float* rows, int64_t blocks, int64_t from, int64_t to) {
    for (int64_t block = 0; block < blocks; ++block) {
      std::copy_n(rows + block * image.stride + from * kBlock, kBlock,
                  rows + block * image.stride + to * kBlock);
    }
  };
  int64_t kept = 0;
  for (int64_t i = 0; i < image.count; ++i) {
    const float* const logits = image.logits + i * kBlock;
    const bool unsure =
        options.depth_confidence > 0.0F && Sigmoid(logits[1]) <= confidence_threshold;
    if (!(Sigmoid(logits[0]) > least) && !unsure) {
      continue;
    }
    if (kept < i) {
      move_row(image.tokens, BlocksOf(layers_.size), i, kept);
      move_row(image.cosines, layers_.half_blocks, i, kept);
      move_row(image.sines, layers_.half_blocks, i, kept);
      image.indices[kept] = image.indices[i];
    }
    ++image.rounds[image.indices[kept]];
    ++kept;
  }
  image.count = kept;
}

}  // namespace gluevo::nn
