#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "gluevo/nn/features.h"
#include "gluevo/nn/weights.h"

// LightGlue once more, as the paper and its published weights have it: in double, straight from the
// tensors, nothing folded, padded, packed or permuted.
namespace gluevo::nn {

class PlainLightGlue {
 public:
  using Matrix = Eigen::MatrixXd;

  explicit PlainLightGlue(const Weights& weights) : weights_(weights) {
    angles_ = Get("posenc.Wr.weight").rows();
    size_ = Get("transformers.0.cross_attn.to_qk.weight").rows();
    head_size_ = 2 * angles_;
  }

  /// After so many attention blocks, two a layer.
  std::pair<Matrix, Matrix> Tokens(const Features& features0, const Features& features1,
                                   int blocks) const {
    Matrix x0 = Start(features0);
    Matrix x1 = Start(features1);
    const Matrix angles0 = Angles(features0);
    const Matrix angles1 = Angles(features1);
    for (int block = 0; block < blocks; ++block) {
      const std::string layer = "transformers." + std::to_string(block / 2) + ".";
      if (block % 2 == 0) {
        x0 = Self(layer + "self_attn.", x0, angles0);
        x1 = Self(layer + "self_attn.", x1, angles1);
      } else {
        const auto [y0, y1] =
            std::pair(Cross(layer + "cross_attn.", x0, x1), Cross(layer + "cross_attn.", x1, x0));
        x0 = y0;
        x1 = y1;
      }
    }
    return {x0, x1};
  }

  /// With last row and column.
  Matrix LogAssignment(const Matrix& x0, const Matrix& x1, int layer) const {
    const std::string name = "log_assignment." + std::to_string(layer) + ".";
    const Matrix scores = Linear(name + "final_proj", x0) *
                          Linear(name + "final_proj", x1).transpose() /
                          std::sqrt(static_cast<double>(size_));
    const Matrix z0 = Linear(name + "matchability", x0);
    const Matrix z1 = Linear(name + "matchability", x1);
    Matrix result = Matrix::Zero(scores.rows() + 1, scores.cols() + 1);
    const auto log_sigmoid = [](double x) { return -std::log1p(std::exp(-x)); };
    for (Eigen::Index i = 0; i < scores.rows(); ++i) {
      for (Eigen::Index j = 0; j < scores.cols(); ++j) {
        result(i, j) = 2.0 * scores(i, j) - std::log(scores.row(i).array().exp().sum()) -
                       std::log(scores.col(j).array().exp().sum()) + log_sigmoid(z0(i, 0)) +
                       log_sigmoid(z1(j, 0));
      }
      result(i, scores.cols()) = log_sigmoid(-z0(i, 0));
    }
    for (Eigen::Index j = 0; j < scores.cols(); ++j) {
      result(scores.rows(), j) = log_sigmoid(-z1(j, 0));
    }
    return result;
  }

 private:
  Matrix Get(const std::string& name) const { return weights_.Get(name).Matrix().cast<double>(); }
  Matrix Linear(const std::string& name, const Matrix& x) const {
    const Eigen::VectorXd bias = weights_.Get(name + ".bias").view().Vector().cast<double>();
    return (x * Get(name + ".weight").transpose()).rowwise() + bias.transpose();
  }

  Matrix Start(const Features& features) const {
    const Matrix descriptors = features.descriptors.cast<double>();
    return weights_.Has("input_proj.weight") ? Linear("input_proj", descriptors) : descriptors;
  }
  Matrix Angles(const Features& features) const {
    const Eigen::RowVector2d size(features.width, features.height);
    const Matrix positions =
        (features.keypoints.cast<double>().rowwise() - size / 2.0) / (size.maxCoeff() / 2.0);
    return positions * Get("posenc.Wr.weight").transpose();
  }

  static Matrix Softmax(Matrix scores) {
    scores.colwise() -= scores.rowwise().maxCoeff().eval();
    scores = scores.array().exp();
    const Eigen::VectorXd sums = scores.rowwise().sum();
    return scores.array().colwise() / sums.array();
  }
  // Neighbouring channels turn by their angle.
  Matrix Rotate(const Matrix& u, const Matrix& angles) const {
    Matrix turned = u;
    for (Eigen::Index row = 0; row < u.rows(); ++row) {
      for (Eigen::Index j = 0; j < angles_; ++j) {
        const double c = std::cos(angles(row, j));
        const double s = std::sin(angles(row, j));
        turned(row, 2 * j) = u(row, 2 * j) * c - u(row, 2 * j + 1) * s;
        turned(row, 2 * j + 1) = u(row, 2 * j + 1) * c + u(row, 2 * j) * s;
      }
    }
    return turned;
  }
  Matrix Mlp(const std::string& block, const Matrix& x, const Matrix& message) const {
    Matrix joined(x.rows(), 2 * size_);
    joined << x, message;
    Matrix hidden = Linear(block + "ffn.0", joined);
    const Matrix gain = Get(block + "ffn.1.weight");
    const Matrix shift = Get(block + "ffn.1.bias");
    for (Eigen::Index row = 0; row < hidden.rows(); ++row) {
      const double mean = hidden.row(row).mean();
      const double variance = (hidden.row(row).array() - mean).square().mean();
      for (Eigen::Index c = 0; c < hidden.cols(); ++c) {
        const double z = (hidden(row, c) - mean) / std::sqrt(variance + 1e-5) * gain(c) + shift(c);
        hidden(row, c) = 0.5 * z * (1.0 + std::erf(z / std::sqrt(2.0)));
      }
    }
    return x + Linear(block + "ffn.3", hidden);
  }
  Matrix Self(const std::string& block, const Matrix& x, const Matrix& angles) const {
    const Matrix qkv = Linear(block + "Wqkv", x);
    Matrix attended(x.rows(), size_);
    for (Eigen::Index head = 0; head < size_ / head_size_; ++head) {
      std::array<Matrix, 3> part;
      for (int t = 0; t < 3; ++t) {
        part[t].resize(x.rows(), head_size_);
        for (Eigen::Index c = 0; c < head_size_; ++c) {
          part[t].col(c) = qkv.col(3 * (head * head_size_ + c) + t);
        }
      }
      attended.middleCols(head * head_size_, head_size_) =
          Softmax(Rotate(part[0], angles) * Rotate(part[1], angles).transpose() /
                  std::sqrt(static_cast<double>(head_size_))) *
          part[2];
    }
    return Mlp(block, x, Linear(block + "out_proj", attended));
  }
  // What x takes from y.
  Matrix Cross(const std::string& block, const Matrix& x, const Matrix& y) const {
    const Matrix u0 = Linear(block + "to_qk", x);
    const Matrix u1 = Linear(block + "to_qk", y);
    const Matrix v1 = Linear(block + "to_v", y);
    Matrix attended(x.rows(), size_);
    for (Eigen::Index head = 0; head < size_ / head_size_; ++head) {
      const auto columns = Eigen::seqN(head * head_size_, head_size_);
      attended(Eigen::all, columns) =
          Softmax(u0(Eigen::all, columns) * u1(Eigen::all, columns).transpose() /
                  std::sqrt(static_cast<double>(head_size_))) *
          v1(Eigen::all, columns);
    }
    return Mlp(block, x, Linear(block + "to_out", attended));
  }

  const Weights& weights_;
  Eigen::Index angles_ = 0;
  Eigen::Index size_ = 0;
  Eigen::Index head_size_ = 0;
};

}  // namespace gluevo::nn
