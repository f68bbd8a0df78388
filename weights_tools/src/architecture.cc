#include "gluevo/weights_tools/architecture.h"

#include <charconv>

#include "open_architectures.h"
#include "tensor_taker.h"

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Weights;

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
  struct Kind {
    const char* tensor;  // That only this network has.
    const char* name;
    Architecture (*read)(const Weights&);
  };
  constexpr std::array<Kind, 4> kKinds = {{
      {"conv1a.weight", "SuperPoint",
       [](const Weights& w) -> Architecture { return ReadSuperPoint(w); }},
      {"final_proj.weight", "SuperGlue",
       [](const Weights& w) -> Architecture { return ReadSuperGlue(w); }},
      {"posenc.Wr.weight", "LightGlue",
       [](const Weights& w) -> Architecture { return ReadLightGlue(w); }},
      {"desc_head.agg_weights", "ALIKED",
       [](const Weights& w) -> Architecture { return ReadAliked(w); }},
  }};
  const Kind* found = nullptr;
  for (const Kind& kind : kKinds) {
    if (!weights.Has(kind.tensor)) {
      continue;
    }
    if (found != nullptr) {
      throw Error(weights.source + ": holds both a " + found->name + " and a " + kind.name +
                  ", expected one network");
    }
    found = &kind;
  }
  if (found == nullptr) {
    throw Error(weights.source +
                ": is neither a SuperPoint nor a SuperGlue, a LightGlue nor an ALIKED: there is no "
                "tensor \"conv1a.weight\", \"final_proj.weight\", \"posenc.Wr.weight\" nor "
                "\"desc_head.agg_weights\"");
  }
  return found->read(weights);
}

std::string NetworkName(const Architecture& architecture) {
  return kNetworkNames[architecture.index()];
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
  } else if (const auto* lightglue = std::get_if<LightGlueArchitecture>(&architecture)) {
    metadata["descriptor_size"] = std::to_string(lightglue->descriptor_size);
    metadata["size"] = std::to_string(lightglue->size);
    metadata["layers"] = std::to_string(lightglue->layers);
    metadata["heads"] = std::to_string(lightglue->heads);
  } else if (const auto* aliked = std::get_if<AlikedArchitecture>(&architecture)) {
    metadata["widths"] = Join(aliked->widths);
    metadata["descriptor_size"] = std::to_string(aliked->descriptor_size);
    metadata["samples"] = std::to_string(aliked->samples);
  }
  return metadata;
}

}  // namespace gluevo::weights_tools
