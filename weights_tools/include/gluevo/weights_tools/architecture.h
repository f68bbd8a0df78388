#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// Channels of a SuperPoint.
struct SuperPointArchitecture {
  /// Output channels of conv1a, conv1b, conv2a, ... conv4b.
  std::array<int64_t, 8> widths = {};
  /// Output channels of convPa and convDa.
  int64_t detector_width = 0;
  int64_t descriptor_width = 0;
  /// Output channels of convDb.
  int64_t descriptor_size = 0;
  /// Layers whose ReLU a scale and a shift of each channel follow.
  int affine_layers = 0;
};

/// Attention heads of the published SuperGlue.
inline constexpr int64_t kPublishedHeads = 4;

/// Metadata's "heads"; throws Error unless it is a positive number.
int64_t ParseHeads(const std::string& text);

/// Layers and channels of a SuperGlue.
struct SuperGlueArchitecture {
  /// Output channels of the keypoint encoder's hidden layers.
  std::vector<int64_t> keypoint_encoder;
  int64_t descriptor_size = 0;
  /// Layers of the graph network, self and cross attention in turns.
  int layers = 0;
  /// Attention heads. No tensor tells their number: as the metadata say, or else 4, as published
  /// ("heads_assumed" in the metadata of a converted file).
  int64_t heads = kPublishedHeads;
  bool heads_assumed = true;
};

/// Layers and channels of a LightGlue, all of which its tensors tell.
struct LightGlueArchitecture {
  int64_t descriptor_size = 0;
  /// Of the tokens that pass through the layers.
  int64_t size = 0;
  int layers = 0;
  int64_t heads = 0;
  /// All layers but the last can tell how sure they are.
  bool adaptive_depth = false;
};

/// Channels of an ALIKED.
struct AlikedArchitecture {
  /// Output channels of the four blocks.
  std::array<int64_t, 4> widths = {};
  int64_t descriptor_size = 0;
  /// Positions that a descriptor is sampled at.
  int64_t samples = 0;
};

using Architecture = std::variant<SuperPointArchitecture, SuperGlueArchitecture,
                                  LightGlueArchitecture, AlikedArchitecture>;
/// What networks are called in metadata and file names, in the order of Architecture.
inline constexpr std::array<const char*, 4> kNetworkNames = {"superpoint", "superglue", "lightglue",
                                                             "aliked"};

/// What network these weights are, from the names and shapes of canonical tensors. Throws Error,
/// naming file and tensor, unless every tensor of one network is there in a shape that fits the
/// others, and none besides.
Architecture ReadArchitecture(const nn::Weights& weights);

/// One of kNetworkNames.
std::string NetworkName(const Architecture& architecture);

/// The entries of a converted file's metadata that tell the architecture: "architecture", and
/// numbers in decimal, several separated by spaces.
std::map<std::string, std::string> ArchitectureMetadata(const Architecture& architecture);

}  // namespace gluevo::weights_tools
