#pragma once

#include <filesystem>

namespace gluevo::vo {

/// Makes a directory and those above it where they do not exist. Throws Error where it cannot,
/// where something else has the name, and where no file can be made in it: whoever calls this first
/// computes nothing that cannot be kept.
void MakeOutputDirectory(const std::filesystem::path& directory);

/// The same for as long as it lives, and for one such object at a time: throws Error where another,
/// of whichever program, has the directory. (A lock of the directory itself: no file tells of it,
/// and it is gone with its program. File systems without locks let all pass.) At its end a
/// directory that it made, and into which nothing was put, goes again.
class OutputDirectory {
 public:
  explicit OutputDirectory(std::filesystem::path path);
  ~OutputDirectory();
  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

 private:
  std::filesystem::path path_;
  bool is_new_;
  int descriptor_ = -1;  ///< Holds the lock.
};

}  // namespace gluevo::vo
