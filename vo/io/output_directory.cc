#include "gluevo/vo/io/output_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"

namespace gluevo::vo {

void MakeOutputDirectory(const std::filesystem::path& directory) {
  if (directory.empty()) {
    throw Error("the folder for output has no name");
  }
  std::error_code code;
  const auto status = std::filesystem::status(directory, code);
  if (std::filesystem::exists(status) && !std::filesystem::is_directory(status)) {
    throw Error(directory.string() + ": is a file; expected a folder for output");
  }
  if (!std::filesystem::exists(status) && std::filesystem::is_symlink(directory, code)) {
    throw Error(directory.string() +
                ": is a link to what is not there; expected a folder for output");
  }
  std::filesystem::create_directories(directory, code);
  if (code) {
    throw Error(directory.string() + ": cannot be made: " + code.message());
  }
  try {
    nn::CheckPlaceForFile(directory / ".gluevo");
  } catch (const Error& error) {
    throw Error(directory.string() + ": no file can be made in it (" + error.what() + ")");
  }
}

OutputDirectory::OutputDirectory(std::filesystem::path path)
    : path_(std::move(path)), is_new_(!std::filesystem::exists(path_)) {
  MakeOutputDirectory(path_);
  descriptor_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ >= 0 && flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(descriptor_);
    throw Error(path_.string() +
                ": another program is writing its results there; expected a folder of its own");
  }
}

OutputDirectory::~OutputDirectory() {
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
  if (is_new_) {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);  // Only where it is empty.
  }
}

}  // namespace gluevo::vo
