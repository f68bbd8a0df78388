#pragma once

#include <string>
#include <vector>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// A batch normalisation with its running statistics (Ioffe and Szegedy 2015): y = gain x + shift
/// in each channel.
struct BatchNorm {
  std::vector<double> gain;
  std::vector<double> shift;
};

/// True where NAME.running_mean is there.
bool HasBatchNorm(const nn::Weights& weights, const std::string& name);

/// Of NAME.weight, .bias, .running_mean and .running_var. Throws Error for tensors that lack or
/// have another shape than [channels], and for variances that are negative.
BatchNorm ReadBatchNorm(const nn::Weights& weights, const std::string& name, int64_t channels,
                        double epsilon);

/// Makes the batch norm that follows a convolution directly part of it. `weight` [channels x ...],
/// `bias` [channels].
void FoldIntoConvolution(const BatchNorm& norm, nn::Tensor<float>& weight, nn::Tensor<float>& bias);

/// Adds NAME.weight, ... of a batch norm that changes nothing, with PyTorch's usual epsilon.
void AddIdentityBatchNorm(nn::Weights& weights, const std::string& name, int64_t channels);

/// PyTorch's default, and the epsilon of every batch norm in a canonical SuperGlue.
inline constexpr double kUsualEpsilon = 1e-5;

/// Changes NAME.weight so that the batch norm is the same with the usual epsilon.
void UseUsualEpsilon(nn::Weights& weights, const std::string& name, double epsilon);

}  // namespace gluevo::weights_tools
