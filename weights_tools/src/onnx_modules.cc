#include "onnx_modules.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <string_view>
#include <utility>

#include "onnx_checks.h"
#include "onnx_origins.h"

namespace gluevo::weights_tools {
namespace {

using nn::Tensor;

// The published SuperGlue has 113.
constexpr std::size_t kMostLinears = 2000;

// The name of the module whose tensor this is, or nothing where it does not end as expected.
std::string ModuleOf(std::string_view tensor, std::string_view ending) {
  constexpr std::string_view kQuantized = "_quantized";
  if (tensor.ends_with(kQuantized)) {
    tensor.remove_suffix(kQuantized.size());
  }
  if (!tensor.ends_with(ending)) {
    return "";
  }
  tensor.remove_suffix(ending.size());
  return std::string(tensor);
}

bool SameValues(const Tensor<float>& a, const Tensor<float>& b) {
  return std::equal(a.data(), a.data() + a.size(), b.data(), b.data() + b.size());
}

bool Same(const Tensor<float>& a, const Tensor<float>& b) {
  return a.shape() == b.shape() && SameValues(a, b);
}

bool Same(const OnnxLinear& a, const OnnxLinear& b) {
  const bool named_apart = !a.name.empty() && !b.name.empty() && a.name != b.name;
  return !named_apart && Same(a.weight, b.weight) && a.bias.has_value() == b.bias.has_value() &&
         (!a.bias || Same(*a.bias, *b.bias));
}

/// Goes through the nodes in their order and gathers.
class Finder {
 public:
  Finder(const OnnxModel& model, const OnnxConstants& constants)
      : model_(model), constants_(constants) {}

  std::vector<OnnxLinear> Find() {
    for (const OnnxNode& node : model_.nodes) {
      Visit(node);
    }
    return std::move(linears_);
  }

 private:
  void Visit(const OnnxNode& node) {
    if (node.outputs.empty() || SeenBefore(node)) {
      return;
    }
    CheckKnownWeights(node);
    if (node.op == "Conv") {
      VisitConvolution(node);
    } else if (node.op == "Gemm") {
      VisitGemm(node);
    } else if (node.op == "MatMul") {
      VisitMatMul(node);
    } else if (node.op == "BatchNormalization") {
      VisitBatchNorm(node);
    } else if (node.op == "Add") {
      VisitAdd(node);
    } else if (node.op == "Mul" || node.op == "Div" || node.op == "Sub") {
      VisitProduct(node);
    } else {
      origins_.PassThrough(node);
    }
  }

  // Layers that run for both images: the same weights once more, whose values need not be made
  // again.
  bool SeenBefore(const OnnxNode& node) {
    if (node.op != "Conv" && node.op != "Gemm") {
      return false;
    }
    std::string key = node.op;
    for (std::size_t i = 1; i < node.inputs.size(); ++i) {
      key += '\n' + node.inputs[i];
    }
    const auto [found, inserted] = first_uses_.emplace(key, &node);
    if (!inserted) {
      origins_.SetAsOf(*found->second, node);
    }
    return !inserted;
  }

  void VisitConvolution(const OnnxNode& node) {
    std::optional<OnnxConstant> weight = Constant(node, 1);
    if (!weight) {
      node.message.Fail(0, "the convolution " + Quoted(node.name) + " has no constant weights");
    }
    CheckConvolution(node, weight->values);
    Add(node, 0, *std::move(weight), Constant(node, 2), node.inputs.size() > 2);
  }

  void VisitGemm(const OnnxNode& node) {
    std::optional<OnnxConstant> weight = Constant(node, 1);
    if (!weight || weight->values.shape().rank() != 2) {
      return;
    }
    if (node.Integer("transB", 0) == 0) {
      weight->values = Transposed(weight->values);
    }
    Add(node, 0, *std::move(weight), Constant(node, 2), node.inputs.size() > 2);
  }

  void VisitMatMul(const OnnxNode& node) {
    for (const std::size_t side : {std::size_t{1}, std::size_t{0}}) {
      std::optional<OnnxConstant> weight = Constant(node, side);
      if (!weight || weight->values.shape().rank() != 2) {
        continue;
      }
      if (side == 1) {
        weight->values = Transposed(weight->values);
      }
      Add(node, 1 - side, *std::move(weight), std::nullopt, false);
      return;
    }
  }

  void Add(const OnnxNode& node, std::size_t input, OnnxConstant weight,
           std::optional<OnnxConstant> bias, bool has_bias) {
    if (has_bias && !bias) {
      node.message.Fail(0, "the bias of " + Quoted(node.name) + " is no constant");
    }
    if (!has_bias) {
      bias = constants_.AddedBehind(node, weight.values.shape()[0]);
    }
    OnnxLinear linear{.name = ModuleOf(weight.root, ".weight"),
                      .weight = std::move(weight.values),
                      .node = &node,
                      .input = origins_.Of(node, input).linear};
    if (bias) {
      if (linear.name.empty()) {
        linear.name = ModuleOf(bias->root, ".bias");
      }
      linear.bias = std::move(bias->values);
    }
    const auto found = std::find_if(linears_.begin(), linears_.end(),
                                    [&](const OnnxLinear& other) { return Same(linear, other); });
    origins_.Set(node, {.linear = static_cast<int>(found - linears_.begin())});
    if (found == linears_.end()) {
      if (linears_.size() == kMostLinears) {
        node.message.Fail(0, "the model has more than " + std::to_string(kMostLinears) +
                                 " layers, expected a SuperPoint or a SuperGlue");
      }
      linears_.push_back(std::move(linear));
    }
  }

  void VisitBatchNorm(const OnnxNode& node) {
    const OnnxOrigin origin = origins_.Of(node, 0);
    std::optional<OnnxConstant> parts[4];
    for (std::size_t i = 0; i < 4; ++i) {
      parts[i] = Constant(node, i + 1);
      if (!parts[i] || origin.linear < 0) {
        node.message.Fail(0, "the batch norm " + Quoted(node.name) +
                                 " does not follow a convolution with constants of its own");
      }
    }
    OnnxBatchNorm norm{.weight = std::move(parts[0]->values),
                       .bias = std::move(parts[1]->values),
                       .mean = std::move(parts[2]->values),
                       .variance = std::move(parts[3]->values),
                       .after_relu = origin.relu};
    const auto epsilon = node.attributes.find("epsilon");
    if (epsilon != node.attributes.end()) {
      norm.epsilon = static_cast<double>(epsilon->second.number);
    }
    const char* endings[] = {".weight", ".bias", ".running_mean", ".running_var"};
    for (std::size_t i = 0; i < 4 && norm.name.empty(); ++i) {
      norm.name = ModuleOf(parts[i]->root, endings[i]);
    }
    OnnxLinear& linear = linears_[static_cast<std::size_t>(origin.linear)];
    if (linear.norm &&
        !(Same(linear.norm->weight, norm.weight) && Same(linear.norm->mean, norm.mean))) {
      node.message.Fail(0, "the batch norm " + Quoted(node.name) + " follows another");
    }
    if (!linear.norm) {
      linear.norm = std::move(norm);
    }
    origins_.Set(node, origin);
  }

  // The sum of a linear map and its bias goes on being that map; other sums are new.
  void VisitAdd(const OnnxNode& node) {
    if (node.inputs.size() != 2 || node.outputs.empty()) {
      return;
    }
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      const OnnxOrigin origin = origins_.Of(node, side);
      if (origin.linear < 0) {
        continue;
      }
      if (const std::optional<OnnxConstant> added = constants_.Get(node.inputs[1 - side])) {
        const auto& bias = linears_[static_cast<std::size_t>(origin.linear)].bias;
        if (!bias || !SameValues(*bias, added->values)) {
          RefuseConstantsBehindLayer(node);
        }
        origins_.Set(node, origin);
      }
    }
  }

  // One factor may be the scale of attention's scores; a factor a channel would be lost.
  void VisitProduct(const OnnxNode& node) const {
    for (std::size_t i = 0; i < node.inputs.size() && node.inputs.size() == 2; ++i) {
      if (origins_.Of(node, i).linear >= 0) {
        const std::optional<OnnxConstant> factor = constants_.Get(node.inputs[1 - i]);
        if (factor && factor->values.size() > 1) {
          RefuseConstantsBehindLayer(node);
        }
      }
    }
  }

  std::optional<OnnxConstant> Constant(const OnnxNode& node, std::size_t input) const {
    return input < node.inputs.size() ? constants_.Get(node.inputs[input]) : std::nullopt;
  }

  const OnnxModel& model_;
  const OnnxConstants& constants_;
  std::vector<OnnxLinear> linears_;
  OnnxOrigins origins_;
  std::map<std::string, const OnnxNode*> first_uses_;
};

}  // namespace

std::vector<OnnxLinear> FindLinears(const OnnxModel& model, const OnnxConstants& constants) {
  return Finder(model, constants).Find();
}

}  // namespace gluevo::weights_tools
