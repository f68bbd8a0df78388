#include "gluevo/weights_tools/architecture.h"

#include <charconv>
#include <set>
#include <string_view>

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Tensor;
using nn::Weights;

/// Gets tensors and remembers which, so that those of no use can be named.
class Taker {
 public:
  explicit Taker(const Weights& weights) : weights_(weights) {}

  void Take(const std::string& name, const Shape& shape) {
    weights_.Get(name, shape);
    taken_.insert(name);
  }

  /// Takes NAME.weight [output x input x kernel...] and NAME.bias; returns the output channels,
  /// which may be any number where `output` is 0.
  int64_t TakeConvolution(const std::string& name, int64_t input, int rank, int64_t kernel,
                          int64_t output = 0) {
    if (output == 0) {
      const Shape& shape = weights_.Get(name + ".weight").shape();
      output = shape.rank() == 0 ? 0 : shape[0];
      if (output == 0) {
        throw Error(weights_.source + ": tensor " + Quoted(name + ".weight") + " has shape " +
                    shape.ToString() + ", expected the weights of a convolution");
      }
    }
    Take(name + ".weight",
         rank == 4 ? Shape{output, input, kernel, kernel} : Shape{output, input, kernel});
    Take(name + ".bias", Shape{output});
    return output;
  }

  /// Takes NAME.scale and NAME.shift where they are there; false where both lack.
  bool TakeAffine(const std::string& name, int64_t channels) {
    if (!weights_.Has(name + ".scale") && !weights_.Has(name + ".shift")) {
      return false;
    }
    Take(name + ".scale", Shape{channels});
    Take(name + ".shift", Shape{channels});
    return true;
  }

  void TakeBatchNorm(const std::string& name, int64_t channels) {
    for (const char* part : {".weight", ".bias", ".running_mean", ".running_var"}) {
      Take(name + part, Shape{channels});
    }
    const Tensor<float>& variance = weights_.Get(name + ".running_var");
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
  const Weights& weights_;
  std::set<std::string> taken_;
};

SuperPointArchitecture ReadSuperPoint(const Weights& weights) {
  constexpr int64_t kCellAndDustbin = 65;
  SuperPointArchitecture architecture;
  Taker taker(weights);
  int64_t channels = 1;
  int i = 0;
  for (const char* name :
       {"conv1a", "conv1b", "conv2a", "conv2b", "conv3a", "conv3b", "conv4a", "conv4b"}) {
    channels = taker.TakeConvolution(name, channels, 4, 3);
    architecture.affine_layers += taker.TakeAffine(name, channels) ? 1 : 0;
    architecture.widths[i++] = channels;
  }
  architecture.detector_width = taker.TakeConvolution("convPa", channels, 4, 3);
  architecture.affine_layers += taker.TakeAffine("convPa", architecture.detector_width) ? 1 : 0;
  taker.TakeConvolution("convPb", architecture.detector_width, 4, 1, kCellAndDustbin);
  architecture.descriptor_width = taker.TakeConvolution("convDa", channels, 4, 3);
  architecture.affine_layers += taker.TakeAffine("convDa", architecture.descriptor_width) ? 1 : 0;
  architecture.descriptor_size =
      taker.TakeConvolution("convDb", architecture.descriptor_width, 4, 1);
  taker.CheckNothingIsLeft("SuperPoint");
  return architecture;
}

void ReadHeads(const Weights& weights, SuperGlueArchitecture& architecture) {
  const auto found = weights.metadata.find("heads");
  if (found != weights.metadata.end()) {
    try {
      architecture.heads = ParseHeads(found->second);
    } catch (const Error& error) {
      throw Error(weights.source + ": " + error.what());
    }
    architecture.heads_assumed = weights.metadata.contains("heads_assumed");
  }
  if (architecture.descriptor_size % architecture.heads != 0) {
    throw Error(weights.source + ": " + std::to_string(architecture.descriptor_size) +
                " channels do not divide into " + std::to_string(architecture.heads) + " heads");
  }
}

SuperGlueArchitecture ReadSuperGlue(const Weights& weights) {
  constexpr int64_t kPositionAndScore = 3;
  SuperGlueArchitecture architecture;
  Taker taker(weights);

  // Convolution, batch norm, ReLU in turns: 0 1 (2) 3 4 (5) ..., the last convolution alone.
  int64_t channels = kPositionAndScore;
  int index = 0;
  const auto encoder = [](int i) { return "kenc.encoder." + std::to_string(i); };
  for (; weights.Has(encoder(index + 1) + ".running_mean"); index += 3) {
    channels = taker.TakeConvolution(encoder(index), channels, 3, 1);
    taker.TakeBatchNorm(encoder(index + 1), channels);
    architecture.keypoint_encoder.push_back(channels);
  }
  const int64_t size = taker.TakeConvolution(encoder(index), channels, 3, 1);
  architecture.descriptor_size = size;

  for (;; ++architecture.layers) {
    const std::string layer = "gnn.layers." + std::to_string(architecture.layers);
    if (!weights.Has(layer + ".attn.merge.weight")) {
      break;
    }
    for (const char* projection : {".attn.proj.0", ".attn.proj.1", ".attn.proj.2", ".attn.merge"}) {
      taker.TakeConvolution(layer + projection, size, 3, 1, size);
    }
    taker.TakeConvolution(layer + ".mlp.0", 2 * size, 3, 1, 2 * size);
    taker.TakeBatchNorm(layer + ".mlp.1", 2 * size);
    taker.TakeConvolution(layer + ".mlp.3", 2 * size, 3, 1, size);
  }
  taker.TakeConvolution("final_proj", size, 3, 1, size);
  taker.Take("bin_score", Shape{});
  taker.CheckNothingIsLeft("SuperGlue of " + std::to_string(architecture.layers) + " layers");
  if (architecture.layers == 0) {
    throw Error(weights.source + ": there is no layer \"gnn.layers.0\"");
  }
  ReadHeads(weights, architecture);
  return architecture;
}

template <typename Numbers>
std::string Join(const Numbers& numbers) {
  std::string text;
  for (const int64_t number : numbers) {
    text += (text.empty() ? "" : " ") + std::to_string(number);
  }
  return text;
}

}  // namespace

int64_t ParseHeads(const std::string& text) {
  int64_t heads = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), heads);
  if (code != std::errc() || end != text.data() + text.size() || heads < 1) {
    throw Error("metadata \"heads\" is " + Quoted(text) + ", expected a positive number");
  }
  return heads;
}

Architecture ReadArchitecture(const Weights& weights) {
  const bool superpoint = weights.Has("conv1a.weight");
  const bool superglue = weights.Has("final_proj.weight");
  if (superpoint && superglue) {
    throw Error(weights.source + ": holds both a SuperPoint and a SuperGlue, expected one network");
  }
  if (superpoint) {
    return ReadSuperPoint(weights);
  }
  if (superglue) {
    return ReadSuperGlue(weights);
  }
  throw Error(weights.source +
              ": is neither a SuperPoint nor a SuperGlue: there is no tensor \"conv1a.weight\" nor "
              "\"final_proj.weight\"");
}

std::string NetworkName(const Architecture& architecture) {
  return std::holds_alternative<SuperPointArchitecture>(architecture) ? "superpoint" : "superglue";
}

std::map<std::string, std::string> ArchitectureMetadata(const Architecture& architecture) {
  std::map<std::string, std::string> metadata = {{"architecture", NetworkName(architecture)}};
  if (const auto* superpoint = std::get_if<SuperPointArchitecture>(&architecture)) {
    metadata["widths"] = Join(superpoint->widths);
    metadata["detector_width"] = std::to_string(superpoint->detector_width);
    metadata["descriptor_width"] = std::to_string(superpoint->descriptor_width);
    metadata["descriptor_size"] = std::to_string(superpoint->descriptor_size);
    if (superpoint->affine_layers > 0) {
      metadata["affine_layers"] = std::to_string(superpoint->affine_layers);
    }
  } else if (const auto* superglue = std::get_if<SuperGlueArchitecture>(&architecture)) {
    metadata["keypoint_encoder"] = Join(superglue->keypoint_encoder);
    metadata["descriptor_size"] = std::to_string(superglue->descriptor_size);
    metadata["layers"] = std::to_string(superglue->layers);
    metadata["heads"] = std::to_string(superglue->heads);
    if (superglue->heads_assumed) {
      metadata["heads_assumed"] = "no tensor tells: as published";
    }
  }
  return metadata;
}

}  // namespace gluevo::weights_tools
