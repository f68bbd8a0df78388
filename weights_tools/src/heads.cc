#include "heads.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "gluevo/nn/error.h"
#include "gluevo/nn/input_file.h"

namespace gluevo::weights_tools {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kLargestConfig = 1 << 20;

bool IsHuggingFaceSuperGlue(const nn::Weights& weights) {
  return std::any_of(weights.tensors.begin(), weights.tensors.end(), [](const auto& entry) {
    return entry.first.find("keypoint_encoder.encoder.0.") != std::string::npos;
  });
}

Json ReadJson(const std::string& path) {
  const nn::InputFile file = nn::ReadInputFile(path);
  if (file.size > kLargestConfig) {
    throw Error(path + ": is of " + std::to_string(file.size) + " bytes, at most " +
                std::to_string(kLargestConfig) + " are read");
  }
  try {
    return Json::parse(file.data.get(), file.data.get() + file.size);
  } catch (const Json::parse_error& error) {
    throw Error(path + ": byte " + std::to_string(error.byte > 0 ? error.byte - 1 : 0) +
                ": is not valid JSON, expected the config of the SuperGlue beside it");
  }
}

std::optional<int64_t> ReadCount(const Json& config, const std::string& path, const char* name) {
  const auto found = config.find(name);
  if (found == config.end()) {
    return std::nullopt;
  }
  constexpr uint64_t kMost = std::numeric_limits<int32_t>::max();
  if (!found->is_number_unsigned() || found->get<uint64_t>() < 1 ||
      found->get<uint64_t>() > kMost) {
    throw Error(path + ": " + Quoted(name) + " is " + Quoted(found->dump(-1, ' ', true)) +
                ", expected a positive number");
  }
  return found->get<int64_t>();
}

std::optional<int64_t> ReadLayers(const Json& config, const std::string& path) {
  constexpr const char* kName = "gnn_layers_types";
  const auto types = config.find(kName);
  if (types == config.end()) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < types->size(); ++i) {
    if (!types->is_array() || (*types)[i] != (i % 2 == 0 ? "self" : "cross")) {
      throw Error(path + ": " + Quoted(kName) +
                  " is not a list of \"self\" and \"cross\" in turns, the one order of layers that "
                  "is known");
    }
  }
  return static_cast<int64_t>(types->size());
}

void CheckSame(const std::string& file, const std::string& what, int64_t said, int64_t other,
               const std::string& who) {
  if (said != other) {
    throw Error(file + ": says " + std::to_string(said) + " " + what + ", " + who + " " +
                std::to_string(other));
  }
}

}  // namespace

std::optional<SuperGlueConfig> ReadSuperGlueConfig(const std::filesystem::path& file,
                                                   const nn::Weights& weights) {
  const std::filesystem::path path = file.parent_path() / "config.json";
  if (!IsHuggingFaceSuperGlue(weights) || !std::filesystem::exists(path)) {
    return std::nullopt;
  }
  SuperGlueConfig config{.path = path.string()};
  const Json json = ReadJson(config.path);
  if (!json.is_object() || json.value("model_type", Json()) != "superglue") {
    return std::nullopt;  // Of something else that lies in this folder, too.
  }
  config.heads = ReadCount(json, config.path, "num_attention_heads").value_or(config.heads);
  config.hidden_size = ReadCount(json, config.path, "hidden_size");
  config.layers = ReadLayers(json, config.path);
  return config;
}

std::optional<int64_t> FindHeads(const nn::Weights& weights,
                                 const std::optional<SuperGlueConfig>& config,
                                 std::optional<int64_t> asked) {
  std::optional<int64_t> heads;
  const std::string what = "attention heads";
  const auto metadata = weights.metadata.find("heads");
  if (metadata != weights.metadata.end()) {
    try {
      heads = ParseHeads(metadata->second);
    } catch (const Error& error) {
      throw Error(weights.source + ": " + error.what());
    }
  }
  if (config) {
    CheckSame(config->path, what, config->heads, heads.value_or(config->heads),
              "the metadata of " + weights.source + " say");
    heads = config->heads;
  }
  if (asked) {
    CheckSame(config ? config->path : weights.source, what, heads.value_or(*asked), *asked,
              "asked for are");
    heads = asked;
  }
  return heads;
}

void CheckConfig(const SuperGlueConfig& config, const SuperGlueArchitecture& architecture,
                 const std::string& source) {
  const std::string who = source + " has";
  CheckSame(config.path, "layers", config.layers.value_or(architecture.layers), architecture.layers,
            who);
  CheckSame(config.path, "channels", config.hidden_size.value_or(architecture.descriptor_size),
            architecture.descriptor_size, who);
}

}  // namespace gluevo::weights_tools
