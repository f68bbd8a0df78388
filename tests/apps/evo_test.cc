// gluevo evaluate gives the figures of the public tool evo: those kept here always, and evo's own
// where it is installed (tests/install_python_tools.sh; GLUEVO_EVO_PYTHON names its python3).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

constexpr double kTolerance = 1e-6;
constexpr const char* kFigures[] = {"ate_se3_m", "ate_sim3_m", "scale", "rpe_frames_translation_m",
                                    "rpe_frames_rotation_deg"};

class EvoTest : public CommandTest {
 protected:
  nlohmann::json Evaluate(const std::string& groundtruth, const std::string& estimate,
                          const std::string& options) const {
    const Outcome outcome = Run("evaluate " + estimate + " " + groundtruth + " --json " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    return nlohmann::json::parse(outcome.out);
  }
  static fs::path Synthetic(const std::string& name) {
    return fs::path(GLUEVO_SOURCE_DIR) / "tests" / "data" / "evaluate" / name;
  }
  static std::string Python() {
    const char* const python = std::getenv("GLUEVO_EVO_PYTHON");
    return python != nullptr ? python : "python3";
  }
  // What evo says, by tests/apps/evo_figures.py.
  nlohmann::json Evo(const std::string& groundtruth, const std::string& estimate,
                     const std::string& options) const {
    const std::string command = Python() + " " + GLUEVO_SOURCE_DIR + "/tests/apps/evo_figures.py " +
                                groundtruth + " " + estimate + " " + options + " >" + Path("evo");
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return nlohmann::json::parse(Contents(Path("evo")));
  }
  void ExpectEvosFigures(const std::string& groundtruth, const std::string& estimate) {
    for (const auto& [options, evo_options] : std::map<std::string, std::string>{
             {"", ""}, {"--delta 10", "10"}, {"--delta 10 --all-pairs", "10 all"}}) {
      SCOPED_TRACE(estimate + " " + options);
      const nlohmann::json ours = Evaluate(groundtruth, estimate, options);
      const nlohmann::json theirs = Evo(groundtruth, estimate, evo_options);
      EXPECT_EQ(ours["pairs"], theirs["pairs"]);
      for (const char* const figure : kFigures) {
        const double difference =
            std::abs(ours[figure].get<double>() - theirs[figure].get<double>());
        EXPECT_LE(difference, kTolerance) << figure;
        largest_difference_ = std::max(largest_difference_, difference);
      }
    }
  }

  double largest_difference_ = 0.0;
};

// From evo 1.38.1, by
//   python3 tests/apps/evo_figures.py tests/data/evaluate/{groundtruth,estimate}.tum [10 [all]]
TEST_F(EvoTest, TheFiguresKeptHere) {
  const std::vector<double> absolute = {0.08189370535220286, 0.019489563838054055,
                                        1.0341636434440067};
  for (const auto& [options, relative] : std::map<std::string, std::vector<double>>{
           {"", {0.024847048625449068, 0.7409962679848113}},
           {"--delta 10", {0.060272769272753865, 0.7397488695882035}},
           {"--delta 10 --all-pairs", {0.05489230021160322, 0.7566603272360081}}}) {
    SCOPED_TRACE(options);
    const nlohmann::json json = Evaluate(Synthetic("groundtruth.tum").string(),
                                         Synthetic("estimate.tum").string(), options);
    EXPECT_EQ(json["pairs"], 116);
    std::vector<double> golden = absolute;
    golden.insert(golden.end(), relative.begin(), relative.end());
    for (std::size_t i = 0; i < golden.size(); ++i) {
      EXPECT_NEAR(json[kFigures[i]].get<double>(), golden[i], kTolerance) << kFigures[i];
    }
  }
}

TEST_F(EvoTest, WhatEvoSays) {
  if (std::system((Python() + " -c 'import evo' 2>/dev/null >&2").c_str()) != 0) {
    GTEST_SKIP() << "evo is not installed for " << Python();
  }
  ExpectEvosFigures(Synthetic("groundtruth.tum").string(), Synthetic("estimate.tum").string());
  const fs::path folder = fs::path(GLUEVO_SHARED_DIR) / "data" / "trajectories";
  if (fs::exists(folder)) {
    for (const auto& truth : fs::directory_iterator(folder / "groundtruth")) {
      const std::string sequence = truth.path().filename().string().substr(0, 5);
      for (const auto& method : fs::directory_iterator(folder / "estimates")) {
        ExpectEvosFigures(truth.path().string(), (method.path() / (sequence + ".tum")).string());
      }
    }
  }
  RecordProperty("largest_difference", std::to_string(largest_difference_));
  std::cout << "largest difference from evo: " << std::scientific << largest_difference_ << '\n';
}

}  // namespace
}  // namespace gluevo::apps
