#include "onnx.h"

#include <algorithm>
#include <string>
#include <vector>

#include "onnx_constants.h"
#include "onnx_model.h"
#include "onnx_modules.h"
#include "onnx_order.h"
#include "onnx_quantized.h"
#include "reshape.h"

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

// How often a value borders a matrix: in a Concat, itself or spread by an Expand.
int BordersMade(const OnnxConstants& constants, const std::string& name) {
  int count = 0;
  for (const OnnxNode* node : constants.ConsumersOf(name)) {
    if (node->op == "Concat") {
      ++count;
    } else if (node->op == "Expand" && node->inputs[0] == name && !node->outputs.empty()) {
      const std::vector<const OnnxNode*> next = constants.ConsumersOf(node->outputs[0]);
      count += static_cast<int>(std::count_if(next.begin(), next.end(),
                                              [](const OnnxNode* n) { return n->op == "Concat"; }));
    }
  }
  return count;
}

// By its name, or, where the export lost it, by its use: it is put beside the scores, below them,
// and in the corner.
void PutDustbin(const OnnxModel& model, const OnnxConstants& constants, nn::Weights& weights) {
  constexpr const char* kName = "bin_score";
  constexpr uint64_t kFloat = 1;
  constexpr int kBorders = 3;
  std::vector<const OnnxTensor*> candidates;
  for (const auto& [name, tensor] : model.tensors) {
    if (name == kName || name.ends_with(std::string(".") + kName)) {
      weights.tensors.insert_or_assign(name, OnnxValues(tensor));
      return;
    }
    const bool one_value = std::all_of(tensor.dims.begin(), tensor.dims.end(),
                                       [](uint64_t extent) { return extent == 1; });
    if (one_value && tensor.type == kFloat && BordersMade(constants, name) == kBorders) {
      candidates.push_back(&tensor);
    }
  }
  if (candidates.size() == 1) {
    weights.tensors.insert_or_assign(kName, Reshaped(OnnxValues(*candidates[0]), nn::Shape{}));
  }
}

}  // namespace

void ParseOnnx(const nn::Bytes& file, Container& container) {
  OnnxModel model = ReadOnnxModel(file);
  UnfoldQuantizedOperators(model);
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
  PutDustbin(model, constants, weights);
}

}  // namespace gluevo::weights_tools
