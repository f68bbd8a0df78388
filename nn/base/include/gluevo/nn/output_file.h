#pragma once

#include <filesystem>
#include <functional>
#include <ostream>

namespace gluevo::nn {

/// Where a file is to be put so that it is found at `path`: there, or where a link at `path` points
/// to. Throws Error where something is there that is no file: a file that takes the place of a
/// device would take it from every program.
std::filesystem::path PlaceForFile(const std::filesystem::path& path);

/// Throws Error where a file could not be put at `path`: as PlaceForFile does, and where its folder
/// is not there or takes no new file. Whoever calls this first computes nothing that cannot be
/// kept.
void CheckPlaceForFile(const std::filesystem::path& path);

/// A file that is there whole or not at all: it is filled beside its place, as
/// NAME.unfinished-PID, and takes the place when it is finished. A lock on it tells other programs
/// that it is being filled; what a killed program left beside the same place has none, and is
/// removed.
class UnfinishedFile {
 public:
  /// Makes the file. Throws Error where it cannot be, and as PlaceForFile does.
  explicit UnfinishedFile(const std::filesystem::path& path);
  /// Removes it where it was not finished.
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  /// Open for reading and writing.
  int descriptor() const { return descriptor_; }
  /// Its name until it is finished.
  const std::filesystem::path& beside() const { return beside_; }
  /// Closes it and puts it in its place. Throws Error where it cannot.
  void Finish();

 private:
  std::filesystem::path path_;
  std::filesystem::path place_;
  std::filesystem::path beside_;
  int descriptor_ = -1;
};

/// Writes a file that is there whole or not at all. Where anything fails, `write` throwing
/// included, what was at `path` before is untouched and nothing is left beside it. Throws Error
/// where it cannot be written, and as PlaceForFile does.
void WriteWholeFile(const std::filesystem::path& path,
                    const std::function<void(std::ostream&)>& write);

/// Writes a file under its own name from the start, for folders that themselves appear only when
/// they are whole. Throws Error where it cannot be written to its end.
void WriteFileInPlace(const std::filesystem::path& path,
                      const std::function<void(std::ostream&)>& write);

}  // namespace gluevo::nn
