#include "partial_directory.h"

#include <fcntl.h>
#include <fnmatch.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <system_error>
#include <vector>

#include "gluevo/nn/error.h"

namespace gluevo::simulation {
namespace fs = std::filesystem;
namespace {

void Make(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw Error(path.string() + ": cannot be made: " + error.message());
}

/// Without the trailing slash that would put ".part" inside the folder.
fs::path WithoutSlash(const fs::path& directory) { return (directory / "").parent_path(); }

}  // namespace

PartialDirectory::PartialDirectory(const fs::path& directory, const std::string& content)
    : directory_(WithoutSlash(directory)), part_(directory_.string() + ".part") {
  if (fs::exists(directory_)) {
    throw Error(directory_.string() + ": exists already, expected the name of a new folder");
  }
  Make(part_);
  Lock();
  try {
    RemoveLeftovers(content);
  } catch (...) {
    ::close(lock_);
    throw;
  }
}

PartialDirectory::~PartialDirectory() {
  std::error_code ignored;
  if (!whole_) fs::remove_all(part_, ignored);
  ::close(lock_);
}

void PartialDirectory::Lock() {
  lock_ = ::open(part_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) throw Error(part_.string() + ": is no folder that could be filled");
  struct stat locked = {};
  struct stat named = {};
  // The other program may have renamed what was opened here, just before it gave up its lock.
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0 || ::fstat(lock_, &locked) != 0 ||
      ::stat(part_.c_str(), &named) != 0 || locked.st_ino != named.st_ino) {
    ::close(lock_);
    throw Error(part_.string() + ": is being filled by another program");
  }
}

void PartialDirectory::RemoveLeftovers(const std::string& content) const {
  const auto is_content = [&](const fs::path& path) {
    return ::fnmatch(content.c_str(), path.filename().c_str(), FNM_EXTMATCH) == 0;
  };
  const std::vector<fs::path> entries(fs::directory_iterator(part_), {});
  if (!std::all_of(entries.begin(), entries.end(), is_content)) {
    throw Error(part_.string() + ": is in the way, and not what an earlier run left");
  }
  for (const fs::path& entry : entries) {
    std::error_code error;
    fs::remove_all(entry, error);
    if (error) throw Error(part_.string() + ": cannot be emptied: " + error.message());
  }
}

fs::path PartialDirectory::Sub(const std::string& name) const {
  Make(part_ / name);
  return part_ / name;
}

void PartialDirectory::Finish() {
  std::error_code error;
  fs::rename(part_, directory_, error);
  if (error) throw Error(directory_.string() + ": cannot be made: " + error.message());
  whole_ = true;
}

}  // namespace gluevo::simulation
