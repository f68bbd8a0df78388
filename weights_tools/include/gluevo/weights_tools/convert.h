#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// Texts for the metadata of a converted file; those that are not given come from the input's
/// metadata of the same name.
struct ConvertOptions {
  /// Where the weights come from: a paper, a page, a recipe.
  std::optional<std::string> source;
  /// Under what licence they stand; "not stated" where neither the options nor the input tell.
  std::optional<std::string> licence;
  /// Anything else a user should know.
  std::optional<std::string> note;
};

/// Reads the weights of one network, from one file or spread over several (no tensor twice), and
/// returns them in the runtime's canonical form: published names and shapes, all float. The
/// metadata tell architecture, source, licence, the names and SHA-256 of the input files and the
/// converter's version. What was converted before comes back as it is. Throws Error, naming file
/// and tensor, for anything that is not exactly one SuperPoint or SuperGlue.
nn::Weights Convert(const std::vector<std::filesystem::path>& inputs,
                    const ConvertOptions& options = {});

}  // namespace gluevo::weights_tools
