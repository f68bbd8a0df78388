#include "onnx_quantized.h"

#include <map>
#include <string_view>
#include <utility>

namespace gluevo::weights_tools {
namespace {

// All take a value, its scale and its zero point, the same of a second one, perhaps a bias in the
// product of both scales, and the scale and the zero point of the output.
struct Form {
  const char* op;
  bool has_bias = false;
  std::size_t bias = 0;         // Which input.
  std::size_t output_zero = 0;  // Which input.
};

constexpr std::size_t kSecond = 3;
constexpr std::size_t kAfterPairs = 6;

const Form* FormOf(std::string_view op) {
  // https://onnx.ai/onnx/operators and ContribOperators.md of ONNX Runtime.
  static const std::map<std::string_view, Form> kForms = {
      {"QLinearConv", {"Conv", true, 8, 7}},
      {"QLinearMatMul", {"MatMul", false, 0, 7}},
      {"com.microsoft.QLinearAdd", {"Add", false, 0, 7}},
      {"com.microsoft.QGemm", {"Gemm", true, 6, 8}}};
  const auto found = kForms.find(op);
  return found == kForms.end() ? nullptr : &found->second;
}

// The axis along which a second input has a scale a channel.
int64_t ChannelAxis(const OnnxNode& node) {
  const bool rows = node.op == "QLinearConv" || node.Integer("transB", 0) != 0;
  return rows ? 0 : 1;
}

/// Makes the nodes that replace one.
class Unfolder {
 public:
  Unfolder(const OnnxNode& node, std::vector<OnnxNode>& nodes) : node_(node), nodes_(nodes) {}

  /// A value in this scale, with a zero point where `zero` is no empty name; returns its name.
  std::string Dequantize(const std::string& what, const std::string& value,
                         const std::string& scale, const std::string& zero, int64_t axis) {
    std::string name = node_.outputs[0] + " " + what;
    nodes_.push_back({.message = node_.message,
                      .op = "DequantizeLinear",
                      .name = node_.name,
                      .inputs = {value, scale, zero},
                      .outputs = {name},
                      .attributes = {{"axis", {.integer = axis}}}});
    return name;
  }

  void Compute(const Form& form, std::vector<std::string> inputs, bool relu) {
    const std::string sum = relu ? node_.outputs[0] + " sum" : node_.outputs[0];
    nodes_.push_back({.message = node_.message,
                      .op = form.op,
                      .name = node_.name,
                      .inputs = std::move(inputs),
                      .outputs = {sum},
                      .attributes = node_.attributes});
    if (relu) {
      nodes_.push_back({.message = node_.message,
                        .op = "Relu",
                        .name = node_.name,
                        .inputs = {sum},
                        .outputs = {node_.outputs[0]}});
    }
  }

 private:
  const OnnxNode& node_;
  std::vector<OnnxNode>& nodes_;
};

// A zero point at the lower end of its type leaves no negative numbers.
bool LeavesNoNegatives(const OnnxModel& model, const std::string& zero) {
  constexpr uint64_t kUint8 = 2;
  constexpr uint64_t kInt8 = 3;
  const auto found = model.tensors.find(zero);
  if (found == model.tensors.end() ||
      (found->second.type != kUint8 && found->second.type != kInt8)) {
    return false;
  }
  const nn::Tensor<float> value = OnnxValues(found->second);
  return value.size() == 1 && value[0] == (found->second.type == kUint8 ? 0.0F : -128.0F);
}

}  // namespace

void UnfoldQuantizedOperators(OnnxModel& model) {
  std::vector<OnnxNode> nodes;
  nodes.reserve(model.nodes.size());
  for (OnnxNode& node : model.nodes) {
    const Form* form = FormOf(node.op);
    if (form == nullptr || node.outputs.empty()) {
      nodes.push_back(std::move(node));
      continue;
    }
    const std::vector<std::string>& in = node.inputs;
    if (in.size() < kAfterPairs) {
      node.message.Fail(0, "a " + node.op + " has " + std::to_string(in.size()) +
                               " inputs, expected at least " + std::to_string(kAfterPairs));
    }
    const int64_t axis = ChannelAxis(node);
    Unfolder unfolder(node, nodes);
    std::vector<std::string> inputs = {
        unfolder.Dequantize("first", in[0], in[1], in[2], 0),
        unfolder.Dequantize("second", in[kSecond], in[kSecond + 1], in[kSecond + 2], axis)};
    if (form->has_bias && in.size() > form->bias && !in[form->bias].empty()) {
      const std::string once =
          unfolder.Dequantize("bias in units", in[form->bias], in[kSecond + 1], "", 0);
      inputs.push_back(unfolder.Dequantize("bias", once, in[1], "", 0));
    }
    const bool relu =
        in.size() > form->output_zero && LeavesNoNegatives(model, in[form->output_zero]);
    unfolder.Compute(*form, std::move(inputs), relu);
  }
  model.nodes = std::move(nodes);
}

}  // namespace gluevo::weights_tools
