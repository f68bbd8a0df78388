#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::vo {

/// The file of a network ("superpoint", ...) that `files` name, itself or by a folder; nothing for
/// the built-in one. `features` tell which of several LightGlues fits. Throws Error where several
/// files could be meant, what is named for a folder is none, or there is neither a file nor a
/// built-in network.
std::optional<std::filesystem::path> FindWeights(const NetworkFiles& files,
                                                 const std::string& network,
                                                 const std::string& features);

/// Throws Error where a folder has no weights of any of these networks: it was not meant for them.
void CheckFolderHolds(const std::filesystem::path& folder,
                      const std::vector<std::string>& networks);

}  // namespace gluevo::vo
