#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::vo {

/// The file of a network ("superpoint", ...) that `files` name, itself or by a folder; nothing for
/// the built-in one. `features` tell which of several LightGlues fits. Throws Error where several
/// files could be meant, the folder holds no weights at all, or there is neither a file nor a
/// built-in network.
std::optional<std::filesystem::path> FindWeights(const NetworkFiles& files,
                                                 const std::string& network,
                                                 const std::string& features);

}  // namespace gluevo::vo
