#include "affine.h"

namespace gluevo::nn {

Affine ReadAffine(const Weights& weights, const std::string& name, int64_t in) {
  const Tensor<float>& weight = weights.Get(name + ".weight");
  const int64_t out = weight.shape().rank() > 0 ? weight.extent(0) : 0;
  CheckShape(weight.shape(), weight.shape().rank() == 2 ? Shape{out, in} : Shape{out, in, 1},
             weights.source + ": " + name + ".weight");
  const Tensor<float>& bias = weights.Get(name + ".bias", Shape{out});
  return {weight.view().Reshaped({out, in}).Matrix().cast<double>(),
          bias.view().Vector().cast<double>()};
}

}  // namespace gluevo::nn
