#include "gluevo/weights_tools/convert.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "containers.h"
#include "dialects.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/weights_tools/architecture.h"
#include "heads.h"
#include "provenance.h"

namespace gluevo::weights_tools {
namespace {

constexpr const char* kConverter = "gluevo-weights " GLUEVO_VERSION;

// One set of tensors from all files; of metadata, the first file's count.
Container Merge(std::vector<Container> parts) {
  Container merged = std::move(parts.front());
  nn::Weights& weights = merged.weights;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    nn::Weights& part = parts[i].weights;
    for (auto& [name, tensor] : part.tensors) {
      if (!weights.tensors.emplace(name, std::move(tensor)).second) {
        throw Error(part.source + ": tensor " + Quoted(name) + " is in an earlier input file too");
      }
    }
    weights.source += " + " + part.source;
  }
  return merged;
}

// Of all parts; the dialect is not known yet.
std::map<std::string, std::string> FreshMetadata(const std::vector<std::filesystem::path>& inputs,
                                                 const std::vector<Container>& parts) {
  std::map<std::string, std::string> metadata = {{"converter", kConverter},
                                                 {"source_form", parts.front().form}};
  const nn::Weights& first = parts.front().weights;
  for (const char* name : {"heads", "licence", "note", "source", "descriptors"}) {
    const auto found = first.metadata.find(name);
    if (found != first.metadata.end()) {
      metadata[name] = found->second;
    }
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const char* separator = i > 0 ? " " : "";
    metadata["source_file"] += separator + inputs[i].filename().string();
    metadata["source_sha256"] += separator + parts[i].weights.checksum;
  }
  return metadata;
}

// As its metadata say, or the config.json beside the first file that has one.
struct HeadsAndConfig {
  std::optional<int64_t> heads;
  std::optional<SuperGlueConfig> config;
};

HeadsAndConfig FindHeadsAndConfig(const std::vector<std::filesystem::path>& inputs,
                                  const std::vector<Container>& parts,
                                  const ConvertOptions& options) {
  HeadsAndConfig found;
  for (std::size_t i = 0; i < parts.size() && !found.config; ++i) {
    found.config = ReadSuperGlueConfig(inputs[i], parts[i].weights);
  }
  found.heads = FindHeads(parts.front().weights, found.config, options.heads);
  return found;
}

bool WasConverted(const std::vector<Container>& parts) {
  const auto& metadata = parts.front().weights.metadata;
  const auto found = metadata.find("converter");
  return parts.size() == 1 && found != metadata.end() &&
         found->second.starts_with("gluevo-weights ");
}

// The file's values are finite; scales, epsilons and what is folded can still overflow.
void CheckFinite(const nn::Weights& weights) {
  for (const auto& [name, tensor] : weights.tensors) {
    if (!std::all_of(tensor.data(), tensor.data() + tensor.size(),
                     [](float value) { return std::isfinite(value); })) {
      throw Error(weights.source + ": tensor " + Quoted(name) +
                  " of the converted network holds an infinite value or NaN, expected finite "
                  "weights");
    }
  }
}

// `fresh` where the metadata are not yet those of a conversion, which tells all of this itself.
void Describe(CanonicalNetwork& network, std::map<std::string, std::string> metadata, bool fresh,
              const HeadsAndConfig& heads, const ConvertOptions& options) {
  nn::Weights& weights = network.weights;
  weights.metadata = std::move(metadata);
  if (heads.heads) {
    weights.metadata["heads"] = std::to_string(*heads.heads);
  }
  if (options.heads) {
    weights.metadata.erase("heads_assumed");
  }
  CheckFinite(weights);
  const Architecture architecture = ReadArchitecture(weights);
  const std::string name = NetworkName(architecture);
  if (name != "superglue") {
    weights.metadata.erase("heads");
  } else if (heads.config) {
    CheckConfig(*heads.config, std::get<SuperGlueArchitecture>(architecture), weights.source);
  }
  for (const auto& [key, text] : ArchitectureMetadata(architecture)) {
    weights.metadata[key] = text;
  }
  if (fresh) {
    weights.metadata["dialect"] = network.dialect;
    for (const auto& [key, text] : UsualProvenance(network.dialect, name)) {
      weights.metadata.emplace(key, text);
    }
  }
  for (const auto& [key, text] :
       {std::pair("source", options.source), std::pair("licence", options.licence),
        std::pair("note", options.note)}) {
    if (text) {
      weights.metadata[key] = *text;
    }
  }
}

}  // namespace

void ConvertOptions::Validate() const {
  if (heads && *heads < 1) {
    throw OptionError("number of heads " + std::to_string(*heads) +
                      " is out of range: expected at least 1");
  }
  if (network &&
      std::find(kNetworkNames.begin(), kNetworkNames.end(), *network) == kNetworkNames.end()) {
    throw OptionError("network " + Quoted(*network) +
                      " is unknown: expected \"superpoint\", \"superglue\", \"lightglue\" or "
                      "\"aliked\"");
  }
}

std::vector<nn::Weights> Convert(const std::vector<std::filesystem::path>& inputs,
                                 const ConvertOptions& options) {
  options.Validate();
  if (inputs.empty()) {
    throw Error("no input file to convert");
  }
  std::vector<Container> parts;
  parts.reserve(inputs.size());
  for (const std::filesystem::path& input : inputs) {
    parts.push_back(ReadContainer(input));
  }
  const bool converted_before = WasConverted(parts);
  const HeadsAndConfig heads = FindHeadsAndConfig(inputs, parts, options);
  const std::map<std::string, std::string> metadata =
      converted_before ? parts.front().weights.metadata : FreshMetadata(inputs, parts);
  Container merged = Merge(std::move(parts));
  const std::string source = merged.weights.source;

  std::vector<nn::Weights> networks;
  for (CanonicalNetwork& network :
       ToCanonical(std::move(merged), heads.heads.value_or(kPublishedHeads))) {
    Describe(network, metadata, !converted_before, heads, options);
    if (!options.network || network.weights.metadata.at("architecture") == *options.network) {
      networks.push_back(std::move(network.weights));
    }
  }
  if (networks.empty()) {
    throw Error(source + ": holds no " + *options.network);
  }
  return networks;
}

}  // namespace gluevo::weights_tools
