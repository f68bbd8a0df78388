#include "onnx_checks.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "gluevo/nn/error.h"

namespace gluevo::weights_tools {

void CheckConvolution(const OnnxNode& node, const nn::Tensor<float>& weight) {
  const auto all = [&node](const char* name, int64_t wanted) {
    const auto found = node.attributes.find(name);
    return found == node.attributes.end() ||
           std::all_of(found->second.integers.begin(), found->second.integers.end(),
                       [wanted](int64_t value) { return value == wanted; });
  };
  const int rank = weight.shape().rank();
  const int64_t kernel = rank > 2 ? weight.extent(2) : 1;
  const auto mode = node.attributes.find("auto_pad");
  const bool same_pad = mode != node.attributes.end() && mode->second.text.starts_with("SAME");
  const bool padded =
      kernel == 1 || same_pad || (node.attributes.contains("pads") && all("pads", kernel / 2));
  if ((rank != 3 && rank != 4) || node.Integer("group", 1) != 1 || !all("strides", 1) ||
      !all("dilations", 1) || !padded || (kernel == 1 && !all("pads", 0))) {
    node.message.Fail(0, "the convolution " + Quoted(node.name) +
                             " has groups, strides, dilations or a padding that neither SuperPoint "
                             "nor SuperGlue has");
  }
}

void CheckKnownWeights(const OnnxNode& node) {
  static const std::set<std::string_view> kOtherWeights = {"ConvInteger",
                                                           "MatMulInteger",
                                                           "ConvTranspose",
                                                           "com.microsoft.FusedConv",
                                                           "com.microsoft.FusedMatMul",
                                                           "com.microsoft.FusedGemm",
                                                           "com.microsoft.nchwc.Conv"};
  if (kOtherWeights.contains(node.op)) {
    node.message.Fail(0, "the model has a " + node.op +
                             ", which is not read: expected Conv, Gemm and MatMul, plain or "
                             "quantised statically; convert the model as it was exported, before "
                             "anything optimised or quantised it");
  }
}

void RefuseConstantsBehindLayer(const OnnxNode& node) {
  node.message.Fail(0, "the " + node.op + " " + Quoted(node.name) +
                           " puts constants behind a layer that are neither its bias nor a batch "
                           "norm: convert the model as it was exported, before anything "
                           "optimised it");
}

}  // namespace gluevo::weights_tools
