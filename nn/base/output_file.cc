#include "gluevo/nn/output_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "descriptor_stream.h"
#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = ".unfinished-";

[[noreturn]] void Fail(const fs::path& path, int error) {
  throw Error(path.string() +
              ": cannot be written: " + std::generic_category().message(error != 0 ? error : EIO));
}

bool IsLinked(int descriptor) {
  struct stat file = {};
  return ::fstat(descriptor, &file) == 0 && S_ISREG(file.st_mode) && file.st_nlink > 0;
}

// A file that can be locked is nobody's: whoever fills one holds its lock. What is removed here is
// what was opened, since all others who remove a file hold its lock, too.
void RemoveWhereAbandoned(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    return;
  }
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && IsLinked(descriptor)) {
    ::unlink(file.c_str());
  }
  ::close(descriptor);
}

void RemoveLeftovers(const fs::path& place) {
  const std::string prefix = place.filename().string() + kMark;
  const auto is_leftover = [&](const std::string& name) {
    return name.size() > prefix.size() && name.starts_with(prefix) &&
           std::all_of(name.begin() + static_cast<std::ptrdiff_t>(prefix.size()), name.end(),
                       [](char c) { return c >= '0' && c <= '9'; });
  };
  std::error_code code;
  const fs::path folder = place.has_parent_path() ? place.parent_path() : ".";
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    if (is_leftover(entry->path().filename().string())) {
      RemoveWhereAbandoned(entry->path());
    }
  }
}

// Somebody who looks for leftovers may find the file before it is locked, and remove it.
int OpenLocked(const fs::path& file) {
  while (true) {
    const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) {
      return -1;
    }
    // File systems without locks have none of ours removed: there a lock is refused to all.
    if (::flock(descriptor, LOCK_EX) != 0 || IsLinked(descriptor)) {
      return descriptor;
    }
    ::close(descriptor);
  }
}

}  // namespace

fs::path PlaceForFile(const fs::path& path) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (fs::is_directory(status) || !path.has_filename()) {
    throw Error(path.string() + ": cannot be written: is a folder");
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error(path.string() + ": cannot be written: is a device or a pipe, expected a file");
  }
  const fs::path target = fs::canonical(path, code);
  return code ? path : target;
}

void CheckPlaceForFile(const fs::path& path) { const UnfinishedFile trial(path); }

UnfinishedFile::UnfinishedFile(const fs::path& path)
    : path_(path), place_(PlaceForFile(path)), beside_(place_) {
  RemoveLeftovers(place_);
  // The process id keeps two programs that write the same file apart.
  beside_ += kMark + std::to_string(::getpid());
  descriptor_ = OpenLocked(beside_);
  if (descriptor_ < 0) {
    Fail(path_, errno);
  }
}

UnfinishedFile::~UnfinishedFile() {
  if (descriptor_ >= 0) {
    ::unlink(beside_.c_str());
    ::close(descriptor_);
  }
}

void UnfinishedFile::Finish() {
  const int copy = ::dup(descriptor_);
  // Some file systems tell only now that there was no room. The lock is held by the other one.
  if (copy < 0 || ::close(copy) != 0) {
    Fail(path_, errno);
  }
  if (::rename(beside_.c_str(), place_.c_str()) != 0) {
    Fail(path_, errno);
  }
  ::close(std::exchange(descriptor_, -1));
}

void WriteWholeFile(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  UnfinishedFile file(path);
  DescriptorStream stream(file.descriptor());
  write(stream);
  stream.flush();
  if (!stream) {
    Fail(path, stream.error());
  }
  file.Finish();
}

void WriteFileInPlace(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    Fail(path, errno);
  }
  DescriptorStream stream(descriptor);
  try {
    write(stream);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  stream.flush();
  const bool is_closed = ::close(descriptor) == 0;
  if (!stream || !is_closed) {
    Fail(path, stream ? errno : stream.error());
  }
}

}  // namespace gluevo::nn
