#include "distinct_outputs.h"

#include <algorithm>
#include <map>
#include <system_error>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/vo/io/image_file.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

bool IsSame(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored) && !fs::is_directory(a, ignored);
}

// Folders may have results among their files, but those have no such names.
bool IsImageOrWeights(const fs::path& name) {
  return vo::HasImageEnding(name) || name.extension() == ".safetensors" ||
         name.extension() == ".npz";
}

// Where a link to what is not there yet leads: what is written to it will be there.
fs::path FollowLinks(fs::path path) {
  constexpr int kMaxLinks = 40;  // As Linux has it.
  std::error_code code;
  for (int i = 0; i < kMaxLinks && fs::is_symlink(path, code); ++i) {
    path = path.parent_path() / fs::read_symlink(path, code);
  }
  return path;
}

// Links followed as far as there is something: most outputs are not there yet.
fs::path PlaceOf(const fs::path& path) {
  std::error_code code;
  const fs::path absolute = FollowLinks(fs::absolute(path, code));
  const fs::path place = fs::weakly_canonical(absolute, code);
  return code ? absolute.lexically_normal() : place;
}

bool IsBelow(const fs::path& place, const fs::path& folder) {
  return std::mismatch(place.begin(), place.end(), folder.begin(), folder.end()).second ==
         folder.end();
}

}  // namespace

void CheckOutputsAreDistinct(const std::vector<fs::path>& outputs) {
  std::map<fs::path, fs::path> names;  // By place.
  for (const fs::path& output : outputs) {
    if (output.empty()) {
      continue;
    }
    const fs::path place = PlaceOf(output);
    for (const auto& [other, name] : names) {
      if (place == other) {
        throw OptionError(output.string() +
                          ": two outputs of this command have this name; expected one of its own "
                          "for each");
      }
      if (IsBelow(place, other) || IsBelow(other, place)) {
        const bool is_this_below = IsBelow(place, other);
        throw OptionError((is_this_below ? output : name).string() + ": lies below " +
                          (is_this_below ? name : output).string() +
                          ", which is another output of this command; expected a place outside "
                          "it");
      }
    }
    names.emplace(place, output);
  }
}

void CheckOutputsAreNoInputs(const std::vector<fs::path>& outputs,
                             const std::vector<fs::path>& inputs) {
  for (const fs::path& output : outputs) {
    for (const fs::path& input : inputs) {
      if (!output.empty() && !input.empty() &&
          (IsSame(output, input) || (IsImageOrWeights(output) && IsFileBelow(output, input)))) {
        throw Error(output.string() +
                    ": cannot be written: is an input of this command, which the output would "
                    "replace");
      }
    }
  }
}

bool IsFileBelow(const fs::path& file, const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code) || !fs::is_regular_file(file, code)) {
    return false;
  }
  const fs::path below = fs::canonical(file, code).lexically_relative(fs::canonical(folder, code));
  return !code && !below.empty() && *below.begin() != "..";
}

}  // namespace gluevo::apps
