#include "gluevo/vo/io/whole_file.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::vo {

// Not a stream of the library: what its iterators throw for a read that fails names no file.
std::string ReadWholeFile(const std::filesystem::path& path) {
  const auto fail = [&] {
    throw Error(path.string() + ": cannot be read: " + std::generic_category().message(errno));
  };
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
