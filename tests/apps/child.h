#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <vector>

namespace gluevo::apps {

/// A running gluevo that can be sent signals; it is waited for at the latest at its end.
class Child {
 public:
  /// What it prints goes to `log`.
  Child(const std::vector<std::string>& arguments, const std::string& log) {
    std::vector<char*> argv;
    std::vector<std::string> words = {GLUEVO_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    argv.reserve(words.size() + 1);
    for (std::string& word : words) {
      argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      dup2(output, STDOUT_FILENO);
      dup2(output, STDERR_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() { Wait(); }

  /// 0 once it was waited for.
  pid_t pid() const { return pid_; }
  void Send(int signal) const {
    if (pid_ > 0) {
      kill(pid_, signal);
    }
  }
  /// As waitpid says.
  int Wait() {
    if (pid_ > 0) {
      waitpid(pid_, &status_, 0);
      pid_ = 0;
    }
    return status_;
  }
  /// The exit code, or 1000 and the signal that ended it.
  int ExitCode() {
    const int status = Wait();
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }

 private:
  pid_t pid_ = 0;
  int status_ = 0;
};

}  // namespace gluevo::apps
