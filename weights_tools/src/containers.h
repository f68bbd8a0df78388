#pragma once

#include <filesystem>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// First stage of a conversion: the named tensors of a file of any container form that is read,
/// with whatever names and shapes its maker gave them. Forms: safetensors, .npz.
nn::Weights ReadContainer(const std::filesystem::path& path);

}  // namespace gluevo::weights_tools
