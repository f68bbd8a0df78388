#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// The named tensors of a file, with whatever names and shapes its maker gave them.
struct Container {
  nn::Weights weights;
  /// "safetensors", "npz", "npy", "torch" (the zip form), "torch-legacy" or "onnx".
  std::string form;
  /// What the file's batch norms add to their variances, where it tells.
  std::optional<double> batch_norm_epsilon;
};

/// First stage of a conversion: reads a file of any form above, which is told by its bytes and not
/// its name. The name of a .npy file less its ending is its tensor's. No code of the file is run.
/// Throws Error with file and offset for anything malformed.
Container ReadContainer(const std::filesystem::path& path);

/// The same from memory; `source` names it in messages.
Container ParseContainer(const void* bytes, std::size_t size, const std::string& source);

}  // namespace gluevo::weights_tools
