#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// y = weight x + bias.
struct Affine {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Matrix weight;  ///< [out x in]
  Eigen::VectorXd bias;
};

/// NAME.weight [out x in], also as that of a 1-wide convolution [out x in x 1], and NAME.bias
/// [out]. Throws Error naming the file and the tensor where they are not of this shape.
Affine ReadAffine(const Weights& weights, const std::string& name, int64_t in);

}  // namespace gluevo::nn
