#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gluevo::weights_tools {

/// Runs a program that is found on the PATH, with all that it prints at the end of `log`, and waits
/// for it. SIGINT, SIGTERM and SIGHUP end the program and not this one. Returns why it failed in a
/// few words, empty where it did not. Throws Error where the log cannot be written.
std::string RunProgram(const std::vector<std::string>& words, const std::filesystem::path& log);

}  // namespace gluevo::weights_tools
