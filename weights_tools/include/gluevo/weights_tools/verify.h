#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/weights_tools/convert.h"

namespace gluevo::weights_tools {

/// One output of two networks, compared.
struct OutputComparison {
  std::string network;  ///< One of kNetworkNames.
  std::string output;   ///< "scores", "descriptors", "keypoints", "assignment" or "matches".
  /// Of maps: root of the mean squared difference over that of the first network's values. Of
  /// keypoints and matches: the share that only one of the two has, 0 to 1.
  double difference = 0;
  double allowed = 0;  ///< Up to this the networks count as the same.

  bool agrees() const { return difference <= allowed; }
};

/// Converts both files, runs the networks on a built-in test image (matchers on points of it
/// with made-up descriptors) and compares what they give. Throws Error where a file cannot be
/// converted, where a network of the first is not in the second, and for networks of different
/// sizes.
std::vector<OutputComparison> Verify(const std::filesystem::path& first,
                                     const std::filesystem::path& second,
                                     const ConvertOptions& options = {});

/// A line for each comparison. Ends with a line feed.
std::string VerificationText(const std::vector<OutputComparison>& comparisons);

/// A JSON list of {"network", "output", "difference", "allowed", "agrees"}.
std::string VerificationJson(const std::vector<OutputComparison>& comparisons);

}  // namespace gluevo::weights_tools
