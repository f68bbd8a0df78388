#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "gluevo/vo/core/frame_result.h"

namespace gluevo::apps {

/// What became of frames, without their tracks, in a file without a name: the record of hours takes
/// no memory until it is asked for.
class FrameLog {
 public:
  /// On the file system of `folder`. Throws Error where no file can be made there.
  explicit FrameLog(const std::filesystem::path& folder);

  /// Throws Error where it cannot be written.
  void Append(const vo::FrameResult& frame);
  /// All of them, to the last bit. Throws Error where they cannot be read.
  std::vector<vo::FrameResult> Read();

 private:
  void Write(const void* address, std::size_t size);
  void Load(void* address, std::size_t size);
  uint32_t NumberOf(const std::string& stage);

  std::filesystem::path folder_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::size_t frames_ = 0;
  std::vector<std::string> stages_;  // By the number that stands for them in the file.
};

}  // namespace gluevo::apps
