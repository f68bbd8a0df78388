#include "gluevo/nn/superglue.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "kernels/kernels.h"
#include "sinkhorn.h"

namespace gluevo::nn {
namespace {

using kernels::BlocksOf;
using kernels::kBlock;

// Folding is done in double, once, at load.
using MatrixD = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
struct Affine {
  MatrixD weight;  // [out x in]
  Eigen::VectorXd bias;
};

// The published names are those of 1-wide convolutions: [out x in x 1].
Affine ReadAffine(const Weights& weights, const std::string& name, int64_t in) {
  const Tensor<float>& weight = weights.Get(name + ".weight");
  const int64_t out = weight.shape().rank() > 0 ? weight.extent(0) : 0;
  CheckShape(weight.shape(), weight.shape().rank() == 2 ? Shape{out, in} : Shape{out, in, 1},
             weights.source + ": " + name + ".weight");
  const Tensor<float>& bias = weights.Get(name + ".bias", Shape{out});
  return {weight.view().Reshaped({out, in}).Matrix().cast<double>(),
          bias.view().Vector().cast<double>()};
}

// A batch normalisation that follows the affine map, with its running statistics (Ioffe and
// Szegedy 2015).
void FoldBatchNorm(const Weights& weights, const std::string& name, Affine& affine) {
  constexpr double kEpsilon = 1e-5;
  const Shape shape{affine.bias.size()};
  const auto vector = [&](const char* part) -> Eigen::VectorXd {
    return weights.Get(name + part, shape).view().Vector().cast<double>();
  };
  const Eigen::VectorXd gain =
      vector(".weight").array() / (vector(".running_var").array() + kEpsilon).sqrt();
  affine.weight = gain.asDiagonal() * affine.weight;
  affine.bias = gain.cwiseProduct(affine.bias - vector(".running_mean")) + vector(".bias");
}

}  // namespace

void SuperGlueOptions::Validate() const {
  if (!(match_threshold >= 0.0F && match_threshold < 1.0F)) {
    throw Error("match threshold " + std::to_string(match_threshold) +
                " is out of range: expected 0 or more and below 1");
  }
  if (sinkhorn_iterations < 1) {
    throw Error("number of Sinkhorn iterations " + std::to_string(sinkhorn_iterations) +
                " is out of range: expected at least 1");
  }
}

SuperGlue::SuperGlue(const Weights& weights, Isa isa) : kernels_(&kernels::KernelsFor(isa)) {
  if (!weights.Has("kenc.encoder.0.weight")) {
    throw Error(weights.source + ": not the weights of a SuperGlue: no tensor " +
                "kenc.encoder.0.weight" +
                (weights.Has("conv1a.weight") ? " (these are a SuperPoint's)" : ""));
  }
  const auto pack = [](const Affine& affine) {
    Linear linear{affine.weight.cols(), affine.weight.rows(), {}, {}};
    const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> weight =
        affine.weight.cast<float>();
    linear.weights = Tensor<float>({kernels::PackedMatrixFloats(linear.out, linear.in)});
    kernels::PackMatrix(weight.data(), linear.in, linear.out, linear.in, linear.weights.data());
    linear.bias = Tensor<float>({BlocksOf(linear.out) * kBlock});
    linear.bias.view().Vector().head(linear.out) = affine.bias.cast<float>();
    return linear;
  };

  // Keypoint encoder: affine maps with batch normalisation and ReLU between them; as modules of one
  // list they are numbered 0, 3, 6, ...
  int64_t channels = 3;
  for (int module = 0; weights.Has("kenc.encoder." + std::to_string(module) + ".weight");
       module += 3) {
    const std::string prefix = "kenc.encoder.";
    Affine affine = ReadAffine(weights, prefix + std::to_string(module), channels);
    channels = affine.bias.size();
    if (weights.Has(prefix + std::to_string(module + 1) + ".weight")) {
      FoldBatchNorm(weights, prefix + std::to_string(module + 1), affine);
    }
    encoder_.push_back(pack(affine));
  }
  size_ = channels;

  if (weights.metadata.contains("heads")) {
    heads_ = std::atoi(weights.metadata.at("heads").c_str());
  }
  if (heads_ < 1 || size_ % heads_ != 0) {
    throw Error(weights.source + ": " + std::to_string(heads_) +
                " heads do not divide the descriptor size " + std::to_string(size_));
  }
  const int64_t head_size = size_ / heads_;

  for (int i = 0;; ++i) {
    const std::string prefix = "gnn.layers." + std::to_string(i) + ".";
    if (!weights.Has(prefix + "attn.merge.weight")) {
      break;
    }
    const Affine q = ReadAffine(weights, prefix + "attn.proj.0", size_);
    const Affine k = ReadAffine(weights, prefix + "attn.proj.1", size_);
    const Affine v = ReadAffine(weights, prefix + "attn.proj.2", size_);
    const Affine merge = ReadAffine(weights, prefix + "attn.merge", size_);
    Affine mlp_a = ReadAffine(weights, prefix + "mlp.0", 2 * size_);
    FoldBatchNorm(weights, prefix + "mlp.1", mlp_a);
    const Affine mlp_b = ReadAffine(weights, prefix + "mlp.3", mlp_a.bias.size());

    // Published channels are (dimension, head); here a head's channels lie together. The bias of k
    // adds the same to all scores of a query, which the softmax cancels. The bias of v passes
    // through attention unchanged, and what follows attention, `merge` and the message's half of
    // the first matrix of the MLP, is one linear map.
    Affine qkv{MatrixD::Zero(3 * size_, size_), Eigen::VectorXd::Zero(3 * size_)};
    MatrixD merge_by_head(size_, size_);
    Eigen::VectorXd v_bias_by_head(size_);
    const double scale = 1.0 / std::sqrt(static_cast<double>(head_size));
    for (int64_t head = 0; head < heads_; ++head) {
      for (int64_t d = 0; d < head_size; ++d) {
        const int64_t from = d * heads_ + head;
        const int64_t to = head * head_size + d;
        qkv.weight.row(to) = scale * q.weight.row(from);
        qkv.bias[to] = scale * q.bias[from];
        qkv.weight.row(size_ + to) = k.weight.row(from);
        qkv.weight.row(2 * size_ + to) = v.weight.row(from);
        merge_by_head.col(to) = merge.weight.col(from);
        v_bias_by_head[to] = v.bias[from];
      }
    }
    const MatrixD message_half = mlp_a.weight.rightCols(size_);
    mlp_a.bias += message_half * (merge_by_head * v_bias_by_head + merge.bias);
    mlp_a.weight.rightCols(size_) = message_half * merge_by_head;
    layers_.push_back({pack(qkv), pack(mlp_a), pack(mlp_b)});
  }
  if (layers_.empty()) {
    throw Error(weights.source + ": a SuperGlue without layers: no tensor " +
                "gnn.layers.0.attn.merge.weight");
  }

  Affine final_projection = ReadAffine(weights, "final_proj", size_);
  const double root = std::pow(static_cast<double>(size_), -0.25);
  final_projection.weight *= root;
  final_projection.bias *= root;
  final_ = pack(final_projection);
  const Tensor<float>& bin_score = weights.Get("bin_score");
  CheckShape({bin_score.size()}, {1}, weights.source + ": bin_score");
  dustbin_score_ = bin_score[0];
}

// Buffers that all layers use, one after the other.
struct SuperGlue::Scratch {
  TensorView<float> qkv;        // [n0 + n1][3 size]
  TensorView<float> attention;  // [n0 + n1][size]
  TensorView<float> hidden;     // [n0 + n1][outputs of mlp_a]
  // Of each image and head: keys packed for products, values with their rows close together.
  TensorView<float> keys;
  TensorView<float> values;
  TensorView<float> scores;  // Of each thread.
};

void SuperGlue::Multiply(const Linear& linear, const MatMulOperands& operands,
                         ThreadPool& pool) const {
  // A multiple of all tile heights, and enough bands for the threads at 200 keypoints.
  constexpr int64_t kRows = 42;
  pool.ParallelFor((operands.rows + kRows - 1) / kRows, [&](int64_t band, int /*worker*/) {
    kernels_->matmul({.a0 = operands.a0,
                      .a0_stride = linear.in - operands.k1,
                      .k0 = linear.in - operands.k1,
                      .a1 = operands.a1,
                      .a1_stride = operands.k1,
                      .k1 = operands.k1,
                      .b = linear.weights.data(),
                      .bias = linear.bias.data(),
                      .relu = operands.relu,
                      .residual = operands.residual,
                      .c = operands.c,
                      .c_stride = linear.out,
                      .columns = linear.out,
                      .row_begin = band * kRows,
                      .row_end = std::min(operands.rows, (band + 1) * kRows)});
  });
}

TensorView<float> SuperGlue::Tokens(const Features& features0, const Features& features1,
                                    Workspace& workspace) const {
  Arena& arena = workspace.arena;
  ThreadPool& pool = workspace.pool;
  const int64_t n0 = features0.size();
  const int64_t n1 = features1.size();
  const TensorView<float> inputs = arena.Allocate<float>({n0 + n1, 3});
  const TensorView<float> tokens = arena.Allocate<float>({n0 + n1, size_});
  const auto fill = [&](const Features& features, int64_t first) {
    const auto width = static_cast<float>(features.width);
    const auto height = static_cast<float>(features.height);
    const float scale = 0.7F * std::max(width, height);
    for (int64_t i = 0; i < features.size(); ++i) {
      float* const input = inputs.data() + (first + i) * 3;
      input[0] = (features.keypoints(i, 0) - width / 2.0F) / scale;
      input[1] = (features.keypoints(i, 1) - height / 2.0F) / scale;
      input[2] = features.scores[i];
    }
    tokens.Matrix().middleRows(first, features.size()) = features.descriptors;
  };
  fill(features0, 0);
  fill(features1, n0);

  TensorView<float> hidden = inputs;
  for (std::size_t i = 0; i < encoder_.size(); ++i) {
    const Linear& linear = encoder_[i];
    const bool last = i + 1 == encoder_.size();
    const TensorView<float> out = last ? tokens : arena.Allocate<float>({n0 + n1, linear.out});
    Multiply(linear,
             {.a0 = hidden.data(),
              .relu = !last,
              .residual = last ? tokens.data() : nullptr,
              .c = out.data(),
              .rows = n0 + n1},
             pool);
    hidden = out;
  }

  const int64_t head_size = size_ / heads_;
  const int64_t most = std::max(n0, n1);
  int64_t widest = 0;
  for (const Layer& layer : layers_) {
    widest = std::max(widest, layer.mlp_a.out);
  }
  const Scratch scratch = {
      .qkv = arena.Allocate<float>({n0 + n1, 3 * size_}),
      .attention = arena.Allocate<float>({n0 + n1, size_}),
      .hidden = arena.Allocate<float>({n0 + n1, widest}),
      .keys = arena.Allocate<float>({2 * heads_, kernels::PackedMatrixFloats(most, head_size)}),
      .values = arena.Allocate<float>({2 * heads_, most, BlocksOf(head_size) * kBlock}),
      .scores = arena.Allocate<float>({pool.size(), kernels::AttentionScratchFloats(most)})};
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    RunLayer(layers_[i], /*cross=*/i % 2 == 1, n0, tokens, scratch, pool);
  }
  return tokens;
}

void SuperGlue::RunLayer(const Layer& layer, bool cross, int64_t n0, TensorView<float> tokens,
                         const Scratch& scratch, ThreadPool& pool) const {
  const int64_t rows = tokens.extent(0);
  const int64_t head_size = size_ / heads_;
  const int64_t value_size = BlocksOf(head_size) * kBlock;
  const int64_t stride = 3 * size_;
  const int64_t first[] = {0, n0};
  const int64_t count[] = {n0, rows - n0};

  Multiply(layer.qkv, {.a0 = tokens.data(), .c = scratch.qkv.data(), .rows = rows}, pool);

  const int64_t keys_size = scratch.keys.extent(1);
  const int64_t values_size = scratch.values.extent(1) * value_size;
  pool.ParallelFor(2 * heads_, [&](int64_t task, int /*worker*/) {
    const int64_t image = task / heads_;
    const float* const k =
        scratch.qkv.data() + first[image] * stride + size_ + task % heads_ * head_size;
    kernels::PackMatrix(k, stride, count[image], head_size, scratch.keys.data() + task * keys_size);
    float* to = scratch.values.data() + task * values_size;
    for (int64_t i = 0; i < count[image]; ++i, to += value_size) {
      std::copy_n(k + size_ + i * stride, head_size, to);
      std::fill(to + head_size, to + value_size, 0.0F);
    }
  });

  constexpr int64_t kRows = 84;
  const int64_t bands0 = (count[0] + kRows - 1) / kRows;
  const int64_t bands = bands0 + (count[1] + kRows - 1) / kRows;
  pool.ParallelFor(bands * heads_, [&](int64_t task, int worker) {
    const int64_t head = task % heads_;
    const int64_t image = task / heads_ < bands0 ? 0 : 1;
    const int64_t band = task / heads_ - image * bands0;
    const int64_t source = cross ? 1 - image : image;
    kernels_->attention({.q = scratch.qkv.data() + first[image] * stride + head * head_size,
                         .q_stride = stride,
                         .k_packed = scratch.keys.data() + (source * heads_ + head) * keys_size,
                         .v = scratch.values.data() + (source * heads_ + head) * values_size,
                         .keys = count[source],
                         .head_dim = head_size,
                         .out = scratch.attention.data() + first[image] * size_ + head * head_size,
                         .out_stride = size_,
                         .row_begin = band * kRows,
                         .row_end = std::min(count[image], (band + 1) * kRows),
                         .scratch = scratch.scores.data() + worker * scratch.scores.extent(1)});
  });

  Multiply(layer.mlp_a,
           {.a0 = tokens.data(),
            .a1 = scratch.attention.data(),
            .k1 = size_,
            .relu = true,
            .c = scratch.hidden.data(),
            .rows = rows},
           pool);
  Multiply(
      layer.mlp_b,
      {.a0 = scratch.hidden.data(), .residual = tokens.data(), .c = tokens.data(), .rows = rows},
      pool);
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
  }
  Arena& arena = workspace.arena;
  ThreadPool& pool = workspace.pool;
  arena.Reset();
  const int64_t n0 = features0.size();
  const int64_t n1 = features1.size();
  const TensorView<float> tokens = Tokens(features0, features1, workspace);

  const TensorView<float> projected = arena.Allocate<float>({n0 + n1, size_});
  Multiply(final_, {.a0 = tokens.data(), .c = projected.data(), .rows = n0 + n1}, pool);
  const TensorView<float> packed = arena.Allocate<float>({kernels::PackedMatrixFloats(n1, size_)});
  kernels::PackMatrix(projected.data() + n0 * size_, size_, n1, size_, packed.data());

  const int64_t stride = BlocksOf(n1 + 1) * kBlock;
  const TensorView<float> scores = arena.Allocate<float>({n0 + 1, stride});
  constexpr int64_t kRows = 42;
  pool.ParallelFor((n0 + kRows - 1) / kRows, [&](int64_t band, int /*worker*/) {
    kernels_->matmul({.a0 = projected.data(),
                      .a0_stride = size_,
                      .k0 = size_,
                      .b = packed.data(),
                      .c = scores.data(),
                      .c_stride = stride,
                      .columns = n1,
                      .row_begin = band * kRows,
                      .row_end = std::min(n0, (band + 1) * kRows)});
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
