#include "child.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "gluevo/nn/error.h"

extern char** environ;

namespace gluevo::weights_tools {
namespace {

constexpr std::array<int, 3> kSignals = {SIGINT, SIGTERM, SIGHUP};

// What a signal handler may look at.
volatile std::sig_atomic_t g_child = 0;
volatile std::sig_atomic_t g_signal = 0;

void EndChild(int signal) {
  g_signal = signal;
  if (g_child > 0) {
    kill(g_child, SIGTERM);
  }
}

/// Hands the signals on for as long as it lives.
class SignalsToChild {
 public:
  SignalsToChild() {
    g_signal = 0;
    struct sigaction action = {};
    action.sa_handler = EndChild;
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      sigaction(kSignals[i], &action, &before_[i]);
    }
  }
  SignalsToChild(const SignalsToChild&) = delete;
  SignalsToChild& operator=(const SignalsToChild&) = delete;
  ~SignalsToChild() {
    g_child = 0;
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      sigaction(kSignals[i], &before_[i], nullptr);
    }
  }

 private:
  std::array<struct sigaction, kSignals.size()> before_ = {};
};

// Nothing on standard input, the log for the rest, and signals as a shell would have them.
int Spawn(std::vector<char*>& argv, int output, pid_t& child) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, output, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  sigaddset(&defaults, SIGXFSZ);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  const int error = posix_spawnp(&child, argv[0], &files, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

}  // namespace

std::string RunProgram(const std::vector<std::string>& words, const std::filesystem::path& log) {
  std::vector<std::string> copies = words;
  std::vector<char*> argv;
  argv.reserve(copies.size() + 1);
  for (std::string& word : copies) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (output < 0) {
    throw Error(log.string() + ": cannot be written: " + std::strerror(errno));
  }
  const SignalsToChild signals;
  pid_t child = 0;
  const int error = Spawn(argv, output, child);
  close(output);
  if (error != 0) {
    return words.front() + " cannot be started: " + std::strerror(error);
  }
  g_child = child;
  if (g_signal != 0) {  // It came before there was a child to end.
    kill(child, SIGTERM);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  g_child = 0;
  if (g_signal != 0) {
    // One wish may come twice: `timeout` and terminals send it to a program and to its group. The
    // second must not find the handlers gone.
    constexpr auto kSameWish = std::chrono::milliseconds(300);
    std::this_thread::sleep_for(kSameWish);
    return std::string("interrupted (") + strsignal(g_signal) + ")";
  }
  if (WIFSIGNALED(status)) {
    return std::string("killed by ") + strsignal(WTERMSIG(status));
  }
  return WEXITSTATUS(status) == 0
             ? ""
             : "it ended with exit code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace gluevo::weights_tools
