#include "gluevo/nn/replaced_file.h"

#include <fstream>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::nn {

namespace fs = std::filesystem;

bool HasMark(const fs::path& file, std::string_view mark) {
  constexpr std::size_t kHead = 200;
  std::string head(kHead, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return head.find(mark) != std::string::npos;
}

void CheckReplacesOnly(const fs::path& output, std::string_view mark, const std::string& kind) {
  std::error_code code;
  if (fs::is_regular_file(output, code) && !fs::is_empty(output, code) && !HasMark(output, mark)) {
    throw Error(output.string() + ": cannot be written: a file is there that is not " + kind +
                ", as the output is");
  }
}

}  // namespace gluevo::nn
