#include "gluevo/vo/io/whole_file.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::vo {

std::string WhyNoFile(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  return !std::filesystem::exists(status)        ? "no such file"
         : std::filesystem::is_directory(status) ? "is a folder, expected a file"
                                                 : "is a device or a pipe, expected a file";
}

// Not a stream of the library: what its iterators throw for a read that fails names no file.
std::string ReadWholeFile(const std::filesystem::path& path) {
  const auto fail = [&] {
    throw Error(path.string() + ": cannot be read: " + std::generic_category().message(errno));
  };
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
      !std::filesystem::is_fifo(status)) {
    throw Error(path.string() + ": " + WhyNoFile(path));
  }
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                             &std::fclose);
  if (file == nullptr) {
    fail();
  }
  std::string bytes;
  std::array<char, 1 << 16> block;
  while (const std::size_t count = std::fread(block.data(), 1, block.size(), file.get())) {
    bytes.append(block.data(), count);
  }
  if (std::ferror(file.get()) != 0) {
    fail();
  }
  return bytes;
}

}  // namespace gluevo::vo
