#include "gluevo/nn/superglue.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <variant>

#include "gluevo/nn/option_error.h"
#include "graph_network.h"
#include "kernels/kernels.h"
#include "sinkhorn.h"
#include "superglue_weights.h"

namespace gluevo::nn {

using kernels::BlocksOf;
using kernels::kBlock;

namespace {

// Encoder, projections and MLPs; a layer's merge, which is part of its MLP here, as published.
double KeypointFlops(const SuperGlueWeights& weights) {
  Eigen::Index multiply_adds = weights.final_projection.weight.size();
  for (const Affine& affine : weights.encoder) {
    multiply_adds += affine.weight.size();
  }
  for (const SuperGlueWeights::Layer& layer : weights.layers) {
    const Eigen::Index merge = weights.size * weights.size;
    multiply_adds += layer.q.weight.size() + layer.k.weight.size() + layer.v.weight.size() + merge +
                     layer.mlp_token.weight.size() + layer.mlp_attend.weight.size() +
                     layer.mlp_out.weight.size();
  }
  return 2.0 * static_cast<double>(multiply_adds);
}

}  // namespace

struct SuperGlue::Network {
  std::variant<GraphNetwork<float>, GraphNetwork<kernels::Bf16Pair>> network;
};

void SuperGlueOptions::Validate() const {
  if (!(match_threshold >= 0.0F && match_threshold < 1.0F)) {
    throw OptionError("match threshold " + std::to_string(match_threshold) +
                      " is out of range: expected 0 or more and below 1");
  }
  if (sinkhorn_iterations < 1) {
    throw OptionError("number of Sinkhorn iterations " + std::to_string(sinkhorn_iterations) +
                      " is out of range: expected at least 1");
  }
}

SuperGlue::SuperGlue(const Weights& weights, Precision precision, Isa isa)
    : kernels_(&kernels::KernelsFor(isa)) {
  const SuperGlueWeights folded = ReadSuperGlueWeights(weights);
  size_ = folded.size;
  keypoint_flops_ = KeypointFlops(folded);
  dustbin_score_ = folded.dustbin_score;
  if (precision == Precision::kBf16) {
    network_ =
        std::make_unique<Network>(Network{GraphNetwork<kernels::Bf16Pair>(folded, *kernels_)});
  } else {
    network_ = std::make_unique<Network>(Network{GraphNetwork<float>(folded, *kernels_)});
  }
}

SuperGlue::SuperGlue(SuperGlue&&) noexcept = default;
SuperGlue& SuperGlue::operator=(SuperGlue&&) noexcept = default;
SuperGlue::~SuperGlue() = default;

int SuperGlue::layers() const {
  return std::visit([](const auto& network) { return network.layers(); }, network_->network);
}

double SuperGlue::Flops(int64_t keypoints0, int64_t keypoints1) const {
  const auto n0 = static_cast<double>(keypoints0);
  const auto n1 = static_cast<double>(keypoints1);
  const auto size = static_cast<double>(size_);
  const int cross_layers = layers() / 2;
  const int self_layers = layers() - cross_layers;
  // Queries times keys, then attention times values.
  const double attention =
      2.0 * size * (self_layers * (n0 * n0 + n1 * n1) + cross_layers * 2.0 * n0 * n1);
  return keypoint_flops_ * (n0 + n1) + 2.0 * (attention + size * n0 * n1);
}

TensorView<float> SuperGlue::LogAssignment(const Features& features0, const Features& features1,
                                           const SuperGlueOptions& options,
                                           Workspace& workspace) const {
  options.Validate();
  for (const Features* const features : {&features0, &features1}) {
    if (features->size() > 0 && features->descriptors.cols() != size_) {
      throw Error("descriptors of " + std::to_string(features->descriptors.cols()) +
                  " values cannot be matched by a SuperGlue of " + std::to_string(size_) +
                  ": the two networks do not belong together");
    }
    if (features->size() == 0 || features->width < 1 || features->height < 1) {
      throw Error("an image without keypoints or without a size cannot be matched");
    }
    if (features->scores.size() != features->size() ||
        features->descriptors.rows() != features->size()) {
      throw Error(std::to_string(features->size()) + " keypoints with " +
                  std::to_string(features->scores.size()) + " scores and " +
                  std::to_string(features->descriptors.rows()) +
                  " descriptors cannot be matched: SuperGlue needs one of both for each");
    }
  }
  Arena& arena = workspace.arena;
  ThreadPool& pool = workspace.pool;
  arena.Reset();
  const int64_t n0 = features0.size();
  const int64_t n1 = features1.size();
  const auto run = [&](const auto& network) {
    return network.Run(features0, features1, workspace);
  };
  const Projected projected = std::visit(run, network_->network);

  const int64_t stride = BlocksOf(n1 + 1) * kBlock;
  const TensorView<float> scores = arena.Allocate<float>({n0 + 1, stride});
  constexpr int64_t kRows = 56;
  pool.ParallelFor((n0 + kRows - 1) / kRows, [&](int64_t band, int /*worker*/) {
    const int64_t begin = band * kRows;
    kernels_->matmul({.a0 = projected.rows0 + begin * kBlock,
                      .a0_block_stride = projected.rows0_block_stride,
                      .a0_blocks = projected.blocks,
                      .b = projected.packed1,
                      .c = scores.data() + begin * stride,
                      .c_stride = stride,
                      .c_block_stride = kBlock,
                      .columns = n1,
                      .rows = std::min(kRows, n0 - begin)});
  });
  scores.Matrix().col(n1).setConstant(dustbin_score_);
  scores.Matrix().row(n0).setConstant(dustbin_score_);
  LogOptimalTransport(scores, n1, options.sinkhorn_iterations, *kernels_, workspace);

  for (int64_t i = 0; i <= n0; ++i) {
    std::copy_n(scores.data() + i * stride, n1 + 1, scores.data() + i * (n1 + 1));
  }
  return {scores.data(), {n0 + 1, n1 + 1}};
}

void SuperGlue::Match(const Features& features0, const Features& features1,
                      const SuperGlueOptions& options, Workspace& workspace,
                      Matches& matches) const {
  options.Validate();
  const int64_t n0 = features0.size();
  const int64_t n1 = features1.size();
  matches.matches0.assign(static_cast<std::size_t>(n0), -1);
  matches.scores0.assign(static_cast<std::size_t>(n0), 0.0F);
  if (n0 == 0 || n1 == 0) {
    return;
  }
  const TensorView<float> log_assignment = LogAssignment(features0, features1, options, workspace);
  const TensorView<int> best0 = workspace.arena.Allocate<int>({n1});  // Of image 1's keypoints.
  const TensorView<float> best0_score = workspace.arena.Allocate<float>({n1});
  std::fill_n(best0.data(), n1, -1);
  std::fill_n(best0_score.data(), n1, -std::numeric_limits<float>::infinity());
  for (int64_t i = 0; i < n0; ++i) {
    const float* const row = log_assignment.data() + i * (n1 + 1);
    matches.matches0[i] = static_cast<int>(std::max_element(row, row + n1) - row);
    for (int64_t j = 0; j < n1; ++j) {
      if (row[j] > best0_score[j]) {
        best0_score[j] = row[j];
        best0[j] = static_cast<int>(i);
      }
    }
  }
  for (int64_t i = 0; i < n0; ++i) {
    int& match = matches.matches0[i];
    const float score = std::exp(log_assignment[i * (n1 + 1) + match]);
    if (best0[match] == i && score > options.match_threshold) {
      matches.scores0[i] = std::min(score, 1.0F);
    } else {
      match = -1;
    }
  }
  workspace.arena.Join();
}

}  // namespace gluevo::nn
