#include "gluevo/nn/output_file.h"

#include <unistd.h>

#include <fstream>
#include <string>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

/// Removes the file when it goes, unless told to keep it.
class Unfinished {
 public:
  explicit Unfinished(std::filesystem::path path) : path_(std::move(path)) {}
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;
  ~Unfinished() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace

void WriteWholeFile(const std::filesystem::path& path,
                    const std::function<void(std::ostream&)>& write) {
  std::filesystem::path beside = path;
  // The process id keeps two programs that write the same file apart.
  beside += ".unfinished-" + std::to_string(getpid());
  std::ofstream stream(beside, std::ios::binary | std::ios::trunc);
  if (!stream) {
    throw Error(path.string() + ": cannot be written: " + std::generic_category().message(errno));
  }
  const Unfinished unfinished(beside);
  write(stream);
  stream.close();
  if (!stream) {
    throw Error(path.string() + ": cannot be written: " + std::generic_category().message(errno));
  }
  std::error_code code;
  std::filesystem::rename(beside, path, code);
  if (code) {
    throw Error(path.string() + ": cannot be written: " + code.message());
  }
}

}  // namespace gluevo::nn
