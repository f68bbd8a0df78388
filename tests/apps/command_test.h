#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "temporary_folder.h"

namespace gluevo::apps {

namespace fs = std::filesystem;

/// What a run of the program printed and how it ended.
struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string error;
};

inline std::string Contents(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Kalibr's camchain of two cameras without distortion, 0.1 m apart.
inline std::string Camchain(int width, int height) {
  std::string text;
  for (const std::string camera : {"0", "1"}) {
    text += "cam" + camera +
            ":\n  camera_model: pinhole\n  distortion_model: radtan\n"
            "  distortion_coeffs: [0, 0, 0, 0]\n  intrinsics: [" +
            std::to_string(width) + ", " + std::to_string(width) + ", " +
            std::to_string(width / 2) + ", " + std::to_string(height / 2) + "]\n  resolution: [" +
            std::to_string(width) + ", " + std::to_string(height) + "]\n";
  }
  return text + "  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
}

/// Runs gluevo as a user does, with files in a temporary folder.
class CommandTest : public testing::Test {
 protected:
  Outcome Run(const std::string& arguments) const { return RunProgram(GLUEVO_PROGRAM, arguments); }
  Outcome RunProgram(const std::string& program, const std::string& arguments) const {
    const std::string command = program + " " + arguments + " >" + (run_.path() / "out").string() +
                                " 2>" + (run_.path() / "error").string();
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, Contents(run_.path() / "out"),
            Contents(run_.path() / "error")};
  }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    return Path(name);
  }
  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::size_t Files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_.path()), {}));
  }

 private:
  TemporaryFolder folder_;
  TemporaryFolder run_;
};

}  // namespace gluevo::apps
