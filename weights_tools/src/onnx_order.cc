#include "onnx_order.h"

#include <algorithm>
#include <array>
#include <string>

#include "onnx.h"

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Tensor;

struct Name {
  std::string linear;
  std::string norm;
};

void Put(const OnnxLinear& linear, const Name& name, nn::Weights& weights) {
  auto& tensors = weights.tensors;
  tensors.insert_or_assign(name.linear + ".weight", linear.weight);
  const Shape channels{linear.weight.extent(0)};
  tensors.insert_or_assign(name.linear + ".bias", linear.bias.value_or(Tensor<float>(channels)));
  if (linear.norm) {
    tensors.insert_or_assign(name.norm + ".weight", linear.norm->weight);
    tensors.insert_or_assign(name.norm + ".bias", linear.norm->bias);
    tensors.insert_or_assign(name.norm + ".running_mean", linear.norm->mean);
    tensors.insert_or_assign(name.norm + ".running_var", linear.norm->variance);
  }
}

bool IsConvolution(const OnnxLinear& linear, int64_t kernel) {
  return linear.weight.shape().rank() == 4 && linear.weight.extent(2) == kernel;
}

// Eight convolutions in a row, and two heads of two each.
bool NameSuperPoint(const std::vector<OnnxLinear>& linears, nn::Weights& weights) {
  constexpr std::size_t kTrunk = 8;
  constexpr int64_t kCellAndDustbin = 65;
  if (linears.size() != kTrunk + 4) {
    return false;
  }
  const bool after_relu = std::any_of(linears.begin(), linears.end(), [](const OnnxLinear& linear) {
    return linear.norm && linear.norm->after_relu;
  });
  const auto name = [&](const std::string& published, const std::string& rpautrat) {
    return after_relu ? Name{rpautrat + ".conv", rpautrat + ".bn"}
                      : Name{"conv" + published, "bn" + published};
  };
  for (std::size_t i = 0; i < kTrunk; ++i) {
    if (!IsConvolution(linears[i], 3) || linears[i].input != static_cast<int>(i) - 1) {
      return false;
    }
    const std::string stage = std::to_string(i / 2);
    Put(linears[i],
        name(std::to_string(i / 2 + 1) + (i % 2 == 0 ? "a" : "b"),
             "backbone." + stage + "." + std::to_string(i % 2)),
        weights);
  }
  std::array<bool, 2> found = {};
  for (std::size_t i = kTrunk; i < linears.size(); ++i) {
    if (!IsConvolution(linears[i], 1)) {
      continue;
    }
    const auto first = static_cast<std::size_t>(linears[i].input);
    if (linears[i].input < static_cast<int>(kTrunk) || !IsConvolution(linears[first], 3) ||
        linears[first].input != static_cast<int>(kTrunk) - 1) {
      return false;
    }
    const bool detector = linears[i].weight.extent(0) == kCellAndDustbin;
    const std::string published = detector ? "P" : "D";
    const std::string rpautrat = detector ? "detector." : "descriptor.";
    Put(linears[first], name(published + "a", rpautrat + "0"), weights);
    Put(linears[i], name(published + "b", rpautrat + "1"), weights);
    found[detector ? 0 : 1] = true;
  }
  return found[0] && found[1];
}

bool HasShape(const OnnxLinear& linear, int64_t rows, int64_t columns) {
  const Shape& shape = linear.weight.shape();
  return shape.rank() >= 2 && shape.rank() <= 3 && shape[0] == rows && shape[1] == columns;
}

// The keypoint encoder, then six maps a layer, then the final projection.
bool NameSuperGlue(const std::vector<OnnxLinear>& linears, nn::Weights& weights) {
  constexpr std::size_t kLayer = 6;
  if (linears.empty()) {
    return false;
  }
  const int64_t size = linears.back().weight.extent(0);
  const auto widest = std::find_if(linears.begin(), linears.end(), [size](const OnnxLinear& l) {
    return HasShape(l, 2 * size, 2 * size);
  });
  const auto before = static_cast<std::size_t>(widest - linears.begin());
  if (widest == linears.end() || before < 5 || !HasShape(linears.back(), size, size)) {
    return false;
  }
  const std::size_t encoder = before - 4;
  if ((linears.size() - encoder - 1) % kLayer != 0) {
    return false;
  }
  for (std::size_t i = 0; i < encoder; ++i) {
    const std::string module = "kenc.encoder.";
    Put(linears[i], {module + std::to_string(3 * i), module + std::to_string(3 * i + 1)}, weights);
  }
  constexpr std::array<const char*, kLayer> kNames = {"attn.proj.0", "attn.proj.1", "attn.proj.2",
                                                      "attn.merge",  "mlp.0",       "mlp.3"};
  for (std::size_t i = encoder; i + 1 < linears.size(); ++i) {
    const std::size_t part = (i - encoder) % kLayer;
    const std::string layer = "gnn.layers." + std::to_string((i - encoder) / kLayer) + ".";
    if (!HasShape(linears[i], part == 4 ? 2 * size : size, part < 4 ? size : 2 * size)) {
      return false;
    }
    // Convolutions run over [channels x points], as the published network does; products of
    // matrices over [points x channels], as Hugging Face's, whose channels are in another order.
    if (linears[i].node->op != "Conv") {
      linears[i].node->message.Fail(
          0,
          "this SuperGlue's layers have lost their names and are no convolutions, so that nothing "
          "tells the order of the channels of its attention heads: convert the .safetensors or "
          ".pth "
          "that it was exported from");
    }
    Put(linears[i], {layer + kNames[part], layer + "mlp.1"}, weights);
  }
  Put(linears.back(), {"final_proj", ""}, weights);
  return true;
}

}  // namespace

bool NameByOrder(const std::vector<OnnxLinear>& linears, nn::Weights& weights) {
  return NameSuperPoint(linears, weights) || NameSuperGlue(linears, weights);
}

}  // namespace gluevo::weights_tools
