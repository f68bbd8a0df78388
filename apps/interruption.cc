#include "interruption.h"

#include <unistd.h>

#include <csignal>
#include <ctime>

namespace gluevo::apps {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

long NowMs() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1000 + now.tv_nsec / 1'000'000;
}

}  // namespace

std::atomic<int> Interruption::first_ = 0;
std::atomic<long> Interruption::first_ms_ = 0;
static_assert(std::atomic<long>::is_always_lock_free, "used by a signal's handler");

void Interruption::Note(int signal) {
  // One wish may come twice: a terminal's Ctrl-C goes to a program and to the one that started it,
  // which may pass it on, and so does what `timeout` sends.
  constexpr long kSameWishMs = 300;
  int none = 0;
  if (first_.compare_exchange_strong(none, signal)) {
    first_ms_ = NowMs();
  } else if (NowMs() - first_ms_ > kSameWishMs) {
    _exit(128 + signal);
  }
}

Interruption::Interruption() {
  first_ = 0;
  for (const int signal : kSignals) {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    // Whoever started this with nohup wants it to go on.
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) {
      continue;
    }
    struct sigaction action = {};
    action.sa_handler = &Interruption::Note;
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
  }
}

Interruption::~Interruption() {
  for (const int signal : kSignals) {
    struct sigaction action = {};
    sigaction(signal, nullptr, &action);
    if (action.sa_handler == &Interruption::Note) {
      action.sa_handler = SIG_DFL;
      sigaction(signal, &action, nullptr);
    }
  }
}

void Interruption::Check() {
  if (const int signal = first_; signal != 0) {
    throw Interrupted{signal};
  }
}

}  // namespace gluevo::apps
