#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/nn/weights.h"
#include "gluevo/weights_tools/architecture.h"

namespace gluevo::weights_tools {

/// What a config.json of Hugging Face's SuperGlueForKeypointMatching tells.
struct SuperGlueConfig {
  std::string path;
  int64_t heads = kPublishedHeads;     ///< Its default where the file does not say.
  std::optional<int64_t> hidden_size;  ///< Channels of descriptors and layers.
  std::optional<int64_t> layers;       ///< Of the graph network, self and cross in turns.
};

/// Of the config.json in the folder of `file`, where `weights` have Hugging Face's names of a
/// SuperGlue and the config is of one; nothing otherwise. Throws Error, naming the config, where it
/// cannot be read or its layers are in another order.
std::optional<SuperGlueConfig> ReadSuperGlueConfig(const std::filesystem::path& file,
                                                   const nn::Weights& weights);

/// Attention heads of a SuperGlue, which no tensor tells: as asked, or as the metadata of the
/// weights say, or the config; nothing where none of them does. Throws Error where two differ.
std::optional<int64_t> FindHeads(const nn::Weights& weights,
                                 const std::optional<SuperGlueConfig>& config,
                                 std::optional<int64_t> asked);

/// Throws Error where the config is of another network.
void CheckConfig(const SuperGlueConfig& config, const SuperGlueArchitecture& architecture,
                 const std::string& source);

}  // namespace gluevo::weights_tools
