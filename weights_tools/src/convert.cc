#include "gluevo/weights_tools/convert.h"

#include <utility>

#include "containers.h"
#include "dialects.h"
#include "gluevo/weights_tools/architecture.h"

namespace gluevo::weights_tools {
namespace {

constexpr const char* kConverter = "gluevo-weights " GLUEVO_VERSION;

// One set of tensors from all files; of metadata, the first file's count.
nn::Weights Merge(std::vector<nn::Weights> parts) {
  nn::Weights merged = std::move(parts.front());
  for (std::size_t i = 1; i < parts.size(); ++i) {
    for (auto& [name, tensor] : parts[i].tensors) {
      if (!merged.tensors.emplace(name, std::move(tensor)).second) {
        throw Error(parts[i].source + ": tensor " + Quoted(name) +
                    " is in an earlier input file too");
      }
    }
    merged.source += " + " + parts[i].source;
  }
  return merged;
}

std::map<std::string, std::string> FreshMetadata(const std::vector<std::filesystem::path>& inputs,
                                                 const std::vector<nn::Weights>& parts) {
  std::map<std::string, std::string> metadata = {
      {"converter", kConverter}, {"dialect", "published"}, {"licence", "not stated"}};
  for (const char* name : {"heads", "licence", "note", "source"}) {
    const auto found = parts.front().metadata.find(name);
    if (found != parts.front().metadata.end()) {
      metadata[name] = found->second;
    }
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const char* separator = i > 0 ? " " : "";
    metadata["source_file"] += separator + inputs[i].filename().string();
    metadata["source_sha256"] += separator + parts[i].checksum;
  }
  return metadata;
}

}  // namespace

nn::Weights Convert(const std::vector<std::filesystem::path>& inputs,
                    const ConvertOptions& options) {
  if (inputs.empty()) {
    throw Error("no input file to convert");
  }
  std::vector<nn::Weights> parts;
  parts.reserve(inputs.size());
  for (const std::filesystem::path& input : inputs) {
    parts.push_back(ReadContainer(input).weights);
  }
  const auto found = parts.front().metadata.find("converter");
  const bool converted_before = parts.size() == 1 && found != parts.front().metadata.end() &&
                                found->second.starts_with("gluevo-weights ");
  std::map<std::string, std::string> metadata =
      converted_before ? parts.front().metadata : FreshMetadata(inputs, parts);

  nn::Weights weights = ToCanonical(Merge(std::move(parts)));
  weights.metadata = std::move(metadata);
  for (const auto& [name, text] : ArchitectureMetadata(ReadArchitecture(weights))) {
    weights.metadata[name] = text;
  }
  for (const auto& [name, text] :
       {std::pair("source", options.source), std::pair("licence", options.licence),
        std::pair("note", options.note)}) {
    if (text) {
      weights.metadata[name] = *text;
    }
  }
  return weights;
}

}  // namespace gluevo::weights_tools
