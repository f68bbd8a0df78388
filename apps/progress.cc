#include "progress.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <utility>

namespace gluevo::apps {

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (terminal_) {
    std::cerr << '\n';
  }
}

void Progress::Update(std::size_t done, const std::string& note) {
  const std::string count = std::to_string(done) + "/" + std::to_string(total_);
  if (terminal_) {
    constexpr std::size_t kWidth = 30;
    const std::size_t filled = total_ == 0 ? kWidth : std::min(kWidth, done * kWidth / total_);
    std::cerr << '\r' << what_ << " [" << std::string(filled, '#')
              << std::string(kWidth - filled, ' ') << "] " << count << "  " << note << "\033[K"
              << std::flush;
    return;
  }
  const std::size_t tenths = total_ == 0 ? 10 : done * 10 / total_;
  if (tenths > tenths_shown_) {
    tenths_shown_ = tenths;
    std::cerr << what_ << ' ' << count << "  " << note << '\n';
  }
}

}  // namespace gluevo::apps
