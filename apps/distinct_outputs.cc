#include "distinct_outputs.h"

#include <system_error>

#include "gluevo/nn/error.h"
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

}  // namespace

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
