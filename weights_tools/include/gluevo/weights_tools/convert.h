#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// What files of converted weights have in their first 200 bytes, and others have not: an output
/// replaces no others.
inline constexpr std::string_view kConvertedMark = R"("converter":"gluevo-weights )";

/// Texts for the metadata of a converted file; those that are not given come from the input's
/// metadata of the same name.
struct ConvertOptions {
  /// Where the weights come from: a paper, a page, a recipe.
  std::optional<std::string> source;
  /// Under what licence they stand; "not stated" where neither the options nor the input tell.
  std::optional<std::string> licence;
  /// Anything else a user should know.
  std::optional<std::string> note;
  /// Attention heads of a SuperGlue, which no tensor tells; else the input's metadata or, for
  /// Hugging Face's names, the config.json beside it, else 4 as published. Two that differ are an
  /// Error.
  std::optional<int64_t> heads;
  /// One of kNetworkNames: the one that is wanted of a file that holds several.
  std::optional<std::string> network;

  /// Throws Error naming the field that is out of range.
  void Validate() const;
};

/// Reads weights of any form and dialect, from one file or spread over several (no tensor twice),
/// and returns the networks among them, at most one of each kind, in the runtime's
/// canonical form: published names and shapes, all float. The metadata tell architecture, dialect,
/// licence, which descriptors fit, the names, form and SHA-256 of the input files and the
/// converter's version. What was converted before comes back as it is. Throws Error, naming file
/// and tensor, for anything that does not make whole networks.
std::vector<nn::Weights> Convert(const std::vector<std::filesystem::path>& inputs,
                                 const ConvertOptions& options = {});

}  // namespace gluevo::weights_tools
