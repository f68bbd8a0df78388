#include "command_line/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <iostream>
#include <streambuf>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::apps {
namespace {

// Standard output as it is, keeping why its first write failed, which streams do not tell.
class KeepsReason : public std::streambuf {
 public:
  KeepsReason() : to_(*std::cout.rdbuf(this)) {}
  ~KeepsReason() override { std::cout.rdbuf(&to_); }
  KeepsReason(const KeepsReason&) = delete;
  KeepsReason& operator=(const KeepsReason&) = delete;

  int reason() const { return reason_; }

 protected:
  int_type overflow(int_type c) override {
    errno = 0;
    return traits_type::eq_int_type(c, traits_type::eof())
               ? traits_type::not_eof(c)
               : Keep(to_.sputc(traits_type::to_char_type(c)), c);
  }
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    errno = 0;
    return Keep(to_.sputn(text, size), size);
  }
  int sync() override {
    errno = 0;
    return Keep(to_.pubsync(), 0);
  }

 private:
  template <typename Result>
  Result Keep(Result result, Result good) {
    if (result != good && reason_ == 0) {
      reason_ = errno;
    }
    return result;
  }

  std::streambuf& to_;
  int reason_ = 0;
};

// As long as the program runs.
KeepsReason& Output() {
  static KeepsReason output;
  return output;
}

}  // namespace

void PrepareStandardStreams() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) < 0 && errno == EBADF) {
      // Opened the wrong way round: what reads or writes it fails as before.
      open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    }
  }
  Output();
}

void CheckStandardOutput() {
  std::cout.flush();
  if (!std::cout) {
    const int reason = Output().reason();
    throw Error("standard output: cannot be written" +
                (reason != 0 ? ": " + std::generic_category().message(reason) : std::string()));
  }
}

}  // namespace gluevo::apps
