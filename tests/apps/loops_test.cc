// gluevo run --loops and gluevo codebook as a user runs them.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class LoopsTest : public CommandTest {
 protected:
  std::string Flight(const std::string& duration_s) const {
    std::string path = Path("flight" + duration_s);
    const Outcome made = Run("simulate -o " + path + " --path hall_loop --duration " + duration_s +
                             " --rate 4 --width 320 --height 240");
    EXPECT_EQ(made.exit_code, 0) << made.error;
    return path;
  }
  nlohmann::json Metrics(const std::string& run) const {
    std::ifstream file(fs::path(Path(run)) / "metrics.json");
    return nlohmann::json::parse(file);
  }
};

TEST_F(LoopsTest, AFlightOfALapAndAHalfIsClosed) {
  // A lap takes 20 s.
  const std::string flight = Flight("30");
  const std::string run = "run " + flight + " --method klt -o ";
  ASSERT_EQ(Run(run + Path("without") + " --loops off").exit_code, 0);
  EXPECT_FALSE(fs::exists(fs::path(Path("without")) / "trajectory_optimized.tum"));
  EXPECT_FALSE(Metrics("without").contains("loops"));
  EXPECT_EQ(Metrics("without")["options"]["loops"], "off");

  const Outcome with = Run(run + Path("with"));
  ASSERT_EQ(with.exit_code, 0) << with.error;
  EXPECT_NE(with.out.find("loops: "), std::string::npos) << with.out;
  const nlohmann::json metrics = Metrics("with");
  EXPECT_GE(metrics["loops"].size(), 3U);
  EXPECT_EQ(metrics["segments_joined"], 0);
  EXPECT_LT(metrics["optimized"]["ate_se3_m"], metrics["ate_se3_m"]);
  // What is without is not changed.
  EXPECT_EQ(Contents(fs::path(Path("with")) / "trajectory.tum"),
            Contents(fs::path(Path("without")) / "trajectory.tum"));
  const auto lines = [](const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines(Contents(fs::path(Path("with")) / "trajectory_optimized.tum")),
            lines(Contents(fs::path(Path("with")) / "trajectory.tum")));
  EXPECT_EQ(metrics["options"]["loops"], "on");
  EXPECT_EQ(metrics["option_origins"]["loops"], "default");
  EXPECT_TRUE(metrics["stages_ms"].contains("loops"));

  // In turn with tracking, and on more threads.
  for (const std::string threads : {"1", "3"}) {
    ASSERT_EQ(Run(run + Path("threads" + threads) + " --threads " + threads).exit_code, 0);
    EXPECT_EQ(Contents(fs::path(Path("threads" + threads)) / "trajectory_optimized.tum"),
              Contents(fs::path(Path("with")) / "trajectory_optimized.tum"));
    EXPECT_EQ(Metrics("threads" + threads)["loops"], metrics["loops"]);
    EXPECT_EQ(Metrics("threads" + threads)["loops_rejected"], metrics["loops_rejected"]);
  }
}

TEST_F(LoopsTest, PlacesAreToldByTheWeightsTheyWereMadeWith) {
  const std::string flight = Flight("1");
  const std::string codebook = Path("places.safetensors");
  const Outcome made = Run("codebook " + flight + " --centres 4 -o " + codebook);
  ASSERT_EQ(made.exit_code, 0) << made.error;
  EXPECT_NE(made.out.find("4 centres"), std::string::npos) << made.out;
  const std::string run = "run " + flight + " --method klt --loops on -o " + Path("out");
  EXPECT_EQ(Run(run + " --codebook " + codebook).exit_code, 0);

  const Outcome missing = Run(run + " --codebook " + Path("none"));
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_NE(missing.error.find("none"), std::string::npos) << missing.error;
  // Weights of another network.
  const Outcome other = Run(run + " --codebook " GLUEVO_SOURCE_DIR
                                  "/tests/data/weights/golden_superpoint_magic_leap.safetensors");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.error.find("centres"), std::string::npos) << other.error;
}

TEST_F(LoopsTest, AKidnappedRigIsFoundAgain) {
  // A lap of 20 s at four frames a second; what is left of the next one begins a quarter of it on.
  const fs::path flight = Flight("30");
  constexpr int kLap = 80;
  constexpr int kTaken = 20;
  for (const std::string camera : {"cam0", "cam1"}) {
    std::vector<fs::path> images;
    for (const auto& entry : fs::directory_iterator(flight / "mav0" / camera / "data")) {
      images.push_back(entry.path());
    }
    std::sort(images.begin(), images.end());
    for (int i = kLap; i < kLap + kTaken; ++i) {
      fs::remove(images[i]);
    }
  }
  const Outcome run =
      Run("run " + flight.string() +
          " --method klt --imu off --loops on --final-adjustment on -o " + Path("kidnapped"));
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const nlohmann::json metrics = Metrics("kidnapped");
  EXPECT_EQ(metrics["segments_joined"], 1);
  const nlohmann::json& quality = metrics["loop_evaluation"];
  EXPECT_EQ(quality["wrong"], 0);
  ASSERT_EQ(quality["joins"].size(), 1U);
  EXPECT_LE(quality["joins"][0]["joined_after_s"], 2.0);
  EXPECT_LT(metrics["optimized"]["ate_se3_m"], 0.1);
  EXPECT_NE(run.out.find("final adjustment: "), std::string::npos) << run.out;
  const nlohmann::json& adjustment = metrics["final_adjustment"];
  EXPECT_GT(adjustment["held_out"], 0);
  EXPECT_EQ(adjustment["kept"],
            adjustment["held_out_error_after_px"] < adjustment["held_out_error_before_px"]);
}

TEST_F(LoopsTest, FinalAdjustmentIsOfWhatLoopsKeep) {
  const Outcome outcome = Run("run " + Flight("1") +
                              " --method klt --loops off --final-adjustment on -o " + Path("out"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.error.find("--loops on"), std::string::npos) << outcome.error;
}

TEST_F(LoopsTest, ARunThatCannotHaveThemSaysSoAndGoesOnUnlessTheyAreAskedFor) {
  const std::string flight = Flight("1");
  std::ofstream(Path("none")) << "no weights";
  const std::string run = "run " + flight + " --method klt --superpoint " + Path("none") + " -o ";
  const Outcome without = Run(run + Path("out"));
  ASSERT_EQ(without.exit_code, 0) << without.error;
  EXPECT_NE(without.error.find("loops are off: "), std::string::npos) << without.error;
  EXPECT_NE(without.error.find(Path("none")), std::string::npos) << without.error;
  const nlohmann::json metrics = Metrics("out");
  EXPECT_EQ(metrics["options"]["loops"], "off");
  EXPECT_NE(metrics["warnings"].dump().find("loops are off: "), std::string::npos);
  EXPECT_FALSE(fs::exists(fs::path(Path("out")) / "trajectory_optimized.tum"));
  EXPECT_EQ(Run(run + Path("out") + " --loops on").exit_code, 1);
}

TEST_F(LoopsTest, AnEmptyNameIsNoMap) {
  const std::string run = "run " + Flight("1") + " --method klt -o " + Path("out");
  for (const std::string option : {" --load-map", " --save-map", " --codebook"}) {
    const Outcome outcome = Run(run + option + " ''");
    EXPECT_NE(outcome.exit_code, 0) << option;
    EXPECT_NE(outcome.error.find("expected a value that is not empty, got \"\""), std::string::npos)
        << outcome.error;
  }
}

TEST_F(LoopsTest, AReplayHasTheLoopsOfItsRun) {
  const std::string flight = Flight("1");
  const std::string matches = Path("matches.h5");
  ASSERT_EQ(Run("run " + flight + " --method klt --loops on -o " + Path("a") + " --save-matches " +
                matches)
                .exit_code,
            0);
  const Outcome outcome =
      Run("run " + flight + " -o " + Path("b") + " --loops on --replay " + matches);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  ASSERT_EQ(Run("run " + flight + " -o " + Path("c") + " --replay " + matches).exit_code, 0);
  EXPECT_EQ(Metrics("c")["options"]["loops"], "off");
  EXPECT_EQ(Contents(fs::path(Path("a")) / "trajectory_optimized.tum"),
            Contents(fs::path(Path("b")) / "trajectory_optimized.tum"));
}

}  // namespace
}  // namespace gluevo::apps
