#include "onnx.h"

#include <algorithm>
#include <string>
#include <vector>

#include "onnx_constants.h"
#include "onnx_model.h"
#include "onnx_modules.h"
#include "onnx_order.h"

namespace gluevo::weights_tools {
namespace {

using nn::Tensor;

void PutTensor(const OnnxNode& node, const std::string& name, Tensor<float> tensor,
               nn::Weights& weights) {
  if (!weights.tensors.emplace(name, std::move(tensor)).second) {
    node.message.Fail(0,
                      "two nodes of the model use different weights of the name " + Quoted(name));
  }
}

bool AllNamed(const std::vector<OnnxLinear>& linears) {
  return std::all_of(linears.begin(), linears.end(), [](const OnnxLinear& linear) {
    return !linear.name.empty() && (!linear.norm || !linear.norm->name.empty());
  });
}

void PutByName(const OnnxLinear& linear, nn::Weights& weights) {
  const OnnxNode& node = *linear.node;
  const nn::Shape channels{linear.weight.extent(0)};
  PutTensor(node, linear.name + ".weight", linear.weight, weights);
  PutTensor(node, linear.name + ".bias", linear.bias.value_or(Tensor<float>(channels)), weights);
  if (linear.norm) {
    PutTensor(node, linear.norm->name + ".weight", linear.norm->weight, weights);
    PutTensor(node, linear.norm->name + ".bias", linear.norm->bias, weights);
    PutTensor(node, linear.norm->name + ".running_mean", linear.norm->mean, weights);
    PutTensor(node, linear.norm->name + ".running_var", linear.norm->variance, weights);
  }
}

// The one epsilon of all batch norms.
std::optional<double> EpsilonOf(const std::vector<OnnxLinear>& linears) {
  std::optional<double> epsilon;
  for (const OnnxLinear& linear : linears) {
    if (linear.norm && epsilon.value_or(linear.norm->epsilon) != linear.norm->epsilon) {
      linear.node->message.Fail(0, "the batch norms of the model have different epsilons");
    }
    if (linear.norm) {
      epsilon = linear.norm->epsilon;
    }
  }
  return epsilon;
}

void PutDustbin(const OnnxModel& model, nn::Weights& weights) {
  for (const auto& [name, tensor] : model.tensors) {
    if (name == "bin_score" || name.ends_with(".bin_score")) {
      weights.tensors.insert_or_assign(name, OnnxValues(tensor));
    }
  }
}

}  // namespace

void ParseOnnx(const nn::Bytes& file, Container& container) {
  const OnnxModel model = ReadOnnxModel(file);
  const OnnxConstants constants(model, file.size());
  const std::vector<OnnxLinear> linears = FindLinears(model, constants);
  nn::Weights& weights = container.weights;
  if (AllNamed(linears)) {
    for (const OnnxLinear& linear : linears) {
      PutByName(linear, weights);
    }
  } else if (!NameByOrder(linears, weights)) {
    file.Fail(0, "the ONNX model has " + std::to_string(linears.size()) +
                     " layers without names, in an order that is neither SuperPoint's nor "
                     "SuperGlue's");
  }
  container.batch_norm_epsilon = EpsilonOf(linears);
  PutDustbin(model, weights);
}

}  // namespace gluevo::weights_tools
