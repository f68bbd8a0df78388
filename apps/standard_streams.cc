#include "standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <iostream>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::apps {

void PrepareStandardStreams() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) < 0 && errno == EBADF) {
      // Opened the wrong way round: what reads or writes it fails as before.
      open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    }
  }
}

void CheckStandardOutput() {
  errno = 0;
  std::cout.flush();
  if (!std::cout) {
    throw Error("standard output: cannot be written" +
                (errno != 0 ? ": " + std::generic_category().message(errno) : std::string()));
  }
}

}  // namespace gluevo::apps
