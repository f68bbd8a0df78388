#include "open_architectures.h"

#include <string>

#include "tensor_taker.h"

namespace gluevo::weights_tools {
namespace {

using nn::Shape;

// The extent of a tensor along an axis, 0 where it has no such axis.
int64_t ExtentOf(const nn::Weights& weights, const std::string& name, int axis) {
  const Shape& shape = weights.Get(name).shape();
  return axis < shape.rank() ? shape[axis] : 0;
}

void TakeLinear(Taker& taker, const std::string& name, int64_t out, int64_t in) {
  taker.Take(name + ".weight", Shape{out, in});
  taker.Take(name + ".bias", Shape{out});
}

void TakeLayer(Taker& taker, const std::string& number, int64_t size) {
  const std::string self = "transformers." + number + ".self_attn.";
  const std::string cross = "transformers." + number + ".cross_attn.";
  TakeLinear(taker, self + "Wqkv", 3 * size, size);
  TakeLinear(taker, self + "out_proj", size, size);
  for (const char* name : {"to_qk", "to_v", "to_out"}) {
    TakeLinear(taker, cross + name, size, size);
  }
  for (const std::string& block : {self, cross}) {
    TakeLinear(taker, block + "ffn.0", 2 * size, 2 * size);
    taker.Take(block + "ffn.1.weight", Shape{2 * size});
    taker.Take(block + "ffn.1.bias", Shape{2 * size});
    TakeLinear(taker, block + "ffn.3", size, 2 * size);
  }
  TakeLinear(taker, "log_assignment." + number + ".matchability", 1, size);
  TakeLinear(taker, "log_assignment." + number + ".final_proj", size, size);
}

}  // namespace

LightGlueArchitecture ReadLightGlue(const nn::Weights& weights) {
  LightGlueArchitecture architecture;
  Taker taker(weights);
  const int64_t angles = ExtentOf(weights, "posenc.Wr.weight", 0);
  taker.Take("posenc.Wr.weight", Shape{angles, 2});
  const auto projection = [](int layer) {
    return "transformers." + std::to_string(layer) + ".cross_attn.to_qk.weight";
  };
  architecture.size = ExtentOf(weights, projection(0), 0);
  if (angles < 1 || architecture.size < 1 || architecture.size % (2 * angles) != 0) {
    throw Error(weights.source + ": tensor " + Quoted("posenc.Wr.weight") + " has " +
                std::to_string(angles) + " angles, which heads of two values each do not divide " +
                "tokens of " + std::to_string(architecture.size));
  }
  architecture.heads = architecture.size / (2 * angles);
  architecture.descriptor_size = architecture.size;
  if (weights.Has("input_proj.weight")) {
    architecture.descriptor_size = ExtentOf(weights, "input_proj.weight", 1);
    TakeLinear(taker, "input_proj", architecture.size, architecture.descriptor_size);
  }
  architecture.adaptive_depth = true;
  for (; weights.Has(projection(architecture.layers)); ++architecture.layers) {
    const std::string number = std::to_string(architecture.layers);
    TakeLayer(taker, number, architecture.size);
    const std::string confidence = "token_confidence." + number + ".token.0";
    if (weights.Has(confidence + ".weight")) {
      TakeLinear(taker, confidence, 1, architecture.size);
    } else if (weights.Has(projection(architecture.layers + 1))) {
      architecture.adaptive_depth = false;
    }
  }
  taker.CheckNothingIsLeft("LightGlue of " + std::to_string(architecture.layers) + " layers");
  return architecture;
}

AlikedArchitecture ReadAliked(const nn::Weights& weights) {
  AlikedArchitecture architecture;
  Taker taker(weights);
  const int64_t group = ExtentOf(weights, "conv1.weight", 0);
  const int64_t size = 4 * group;
  architecture.descriptor_size = size;
  int64_t in = 3;
  for (int i = 0; i < 4; ++i) {
    const std::string block = "block" + std::to_string(i + 1) + ".";
    const bool deformable = i >= 2;
    const std::string plain = deformable ? ".regular_conv" : "";
    const int64_t out = ExtentOf(weights, block + "conv1" + plain + ".weight", 0);
    architecture.widths[static_cast<std::size_t>(i)] = out;
    for (const auto& [number, inputs] : {std::pair("1", in), {"2", out}}) {
      const std::string convolution = block + "conv" + number;
      taker.Take(convolution + plain + ".weight", Shape{out, inputs, 3, 3});
      taker.TakeBatchNorm(block + "bn" + number, out);
      if (deformable) {
        taker.TakeConvolution(convolution + ".offset_conv", inputs, 4, 3, 18);
      }
    }
    if (i > 0) {
      taker.TakeConvolution(block + "downsample", in, 4, 1, out);
    }
    taker.Take("conv" + std::to_string(i + 1) + ".weight", Shape{group, out, 1, 1});
    in = out;
  }
  int64_t channels = ExtentOf(weights, "score_head.0.weight", 0);
  taker.Take("score_head.0.weight", Shape{channels, size, 1, 1});
  for (const char* layer : {"score_head.2.weight", "score_head.4.weight", "score_head.6.weight"}) {
    const int64_t out = ExtentOf(weights, layer, 0);
    taker.Take(layer, Shape{out, channels, 3, 3});
    channels = out;
  }
  const int64_t samples = ExtentOf(weights, "desc_head.agg_weights", 0);
  architecture.samples = samples;
  taker.Take("desc_head.agg_weights", Shape{samples, size, size});
  taker.TakeConvolution("desc_head.offset_conv.0", size, 4, 3, 2 * samples);
  taker.TakeConvolution("desc_head.offset_conv.2", 2 * samples, 4, 1, 2 * samples);
  taker.Take("desc_head.sf_conv.weight", Shape{size, size, 1, 1});
  taker.CheckNothingIsLeft("ALIKED");
  return architecture;
}

}  // namespace gluevo::weights_tools
