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

std::filesystem::path PlaceForFile(const std::filesystem::path& path) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (std::filesystem::is_directory(status)) {
    throw Error(path.string() + ": cannot be written: is a folder");
  }
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw Error(path.string() + ": cannot be written: is a device or a pipe, expected a file");
  }
  const std::filesystem::path target = std::filesystem::canonical(path, code);
  return code ? path : target;
}

void WriteWholeFile(const std::filesystem::path& path,
                    const std::function<void(std::ostream&)>& write) {
  const std::filesystem::path place = PlaceForFile(path);
  std::filesystem::path beside = place;
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
  std::filesystem::rename(beside, place, code);
  if (code) {
    throw Error(path.string() + ": cannot be written: " + code.message());
  }
}

}  // namespace gluevo::nn
