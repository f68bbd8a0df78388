#pragma once

#include <filesystem>
#include <string>

namespace gluevo::simulation {

/// What any simulation puts into its folder: a sequence, or training data.
constexpr const char* kSimulatedContent = "@(mav0|rooms_*)";

/// A new folder that is filled under the name "DIRECTORY.part", takes its own name when it is
/// whole, and vanishes otherwise. What a killed program left under that name is replaced; while
/// another program is filling it (a lock on the folder tells), it is not.
class PartialDirectory {
 public:
  /// Throws Error where the directory exists, is being filled, or cannot be made, and where
  /// "DIRECTORY.part" holds anything but files or folders called `content` (a shell's pattern,
  /// "@(a|b)" for alternatives).
  PartialDirectory(const std::filesystem::path& directory, const std::string& content);
  ~PartialDirectory();
  PartialDirectory(const PartialDirectory&) = delete;
  PartialDirectory& operator=(const PartialDirectory&) = delete;

  /// Where the files go.
  const std::filesystem::path& path() const { return part_; }
  /// A folder below, made with its parents.
  std::filesystem::path Sub(const std::string& name) const;
  void Finish();

 private:
  void Lock();
  void RemoveLeftovers(const std::string& content) const;

  std::filesystem::path directory_;
  std::filesystem::path part_;
  int lock_ = -1;
  bool whole_ = false;
};

}  // namespace gluevo::simulation
