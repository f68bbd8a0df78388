#pragma once

#include <cstddef>
#include <string>

namespace gluevo::apps {

/// How far long work is, on stderr: a bar that redraws itself on a terminal, else a plain line for
/// each tenth.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Ends the bar's line.
  ~Progress();

  /// `done` of the total are done; `note` is shown behind.
  void Update(std::size_t done, const std::string& note);

 private:
  std::string what_;
  std::size_t total_;
  std::size_t tenths_shown_ = 0;
  bool terminal_;
};

}  // namespace gluevo::apps
