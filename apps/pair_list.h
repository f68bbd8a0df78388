#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace gluevo::apps {

/// The pairs of a list, each once, by the names that the features have.
struct PairList {
  std::vector<std::pair<std::string, std::string>> pairs;
  int repeated = 0;  ///< Lines that name a pair which is there already.
  /// Lines whose names differ from those of the features: other folders before them, "./", or
  /// backslashes.
  int renamed = 0;
};

/// Reads a list of pairs as hloc and SuperGlue write it, checked against the names of images that
/// have features (sorted): two names a line, between blanks, a tab or a comma; further columns
/// (scores, cameras) are passed over, and so are comments (#), blank lines, line ends of any system
/// and a byte order mark. Throws Error with file and line where a line has no two names, with all
/// counts where images have no features, and for two pairs that would have the same place in a file
/// of matches.
PairList ReadPairList(const std::filesystem::path& path, const std::vector<std::string>& images);

}  // namespace gluevo::apps
