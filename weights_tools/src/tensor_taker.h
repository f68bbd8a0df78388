#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// Gets tensors and remembers which, so that those of no use can be named.
class Taker {
 public:
  explicit Taker(const nn::Weights& weights) : weights_(weights) {}

  void Take(const std::string& name, const nn::Shape& shape) {
    weights_.Get(name, shape);
    taken_.insert(name);
  }

  /// Takes NAME.weight [output x input x kernel...] and NAME.bias; returns the output channels,
  /// which may be any number where `output` is 0.
  int64_t TakeConvolution(const std::string& name, int64_t input, int rank, int64_t kernel,
                          int64_t output = 0) {
    if (output == 0) {
      const nn::Shape& shape = weights_.Get(name + ".weight").shape();
      output = shape.rank() == 0 ? 0 : shape[0];
      if (output == 0) {
        throw Error(weights_.source + ": tensor " + Quoted(name + ".weight") + " has shape " +
                    shape.ToString() + ", expected the weights of a convolution");
      }
    }
    Take(name + ".weight",
         rank == 4 ? nn::Shape{output, input, kernel, kernel} : nn::Shape{output, input, kernel});
    Take(name + ".bias", nn::Shape{output});
    return output;
  }

  /// Takes NAME.scale and NAME.shift where they are there; false where both lack.
  bool TakeAffine(const std::string& name, int64_t channels) {
    if (!weights_.Has(name + ".scale") && !weights_.Has(name + ".shift")) {
      return false;
    }
    Take(name + ".scale", nn::Shape{channels});
    Take(name + ".shift", nn::Shape{channels});
    return true;
  }

  void TakeBatchNorm(const std::string& name, int64_t channels) {
    for (const char* part : {".weight", ".bias", ".running_mean", ".running_var"}) {
      Take(name + part, nn::Shape{channels});
    }
    const nn::Tensor<float>& variance = weights_.Get(name + ".running_var");
    for (int64_t i = 0; i < variance.size(); ++i) {
      if (variance[i] < 0) {
        throw Error(weights_.source + ": tensor " + Quoted(name + ".running_var") +
                    " holds a negative variance at index " + std::to_string(i));
      }
    }
  }

  void CheckNothingIsLeft(const std::string& network) const {
    for (const auto& [name, tensor] : weights_.tensors) {
      if (!taken_.contains(name)) {
        throw Error(weights_.source + ": tensor " + Quoted(name) + " does not belong to a " +
                    network);
      }
    }
  }

 private:
  const nn::Weights& weights_;
  std::set<std::string> taken_;
};

}  // namespace gluevo::weights_tools
