#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace gluevo::apps {

/// Starts this very program anew with other arguments; what it prints goes to the end of `log`. It
/// ends where this process does, and gets no signal of a terminal but by this one. Throws Error
/// where the log cannot be written or nothing started.
pid_t StartSelf(const std::vector<std::string>& arguments, const std::filesystem::path& log);

/// How a child ended, from what waitpid says: empty for exit code 0, else "ended with exit code 1"
/// or "was killed by signal 11 (Segmentation fault)".
std::string DescribeEnd(int status);

}  // namespace gluevo::apps
