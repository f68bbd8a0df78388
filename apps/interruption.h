#pragma once

#include <atomic>

namespace gluevo::apps {

/// What a command throws that was asked to end by a signal, when all is put in order.
struct Interrupted {
  int signal = 0;
  /// As shells report a program that a signal ended.
  int exit_code() const { return 128 + signal; }
};

/// While it lives, SIGINT (Ctrl-C), SIGTERM and SIGHUP (a terminal that is closed) do not end the
/// program but are noted, so that long work can end in order. A second one ends it at once. One at
/// a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// The signal that came; 0 while none has.
  static int signal() { return first_; }
  /// Throws Interrupted where a signal came.
  static void Check();

 private:
  static void Note(int signal);

  static std::atomic<int> first_;
  static std::atomic<long> first_ms_;
};

}  // namespace gluevo::apps
