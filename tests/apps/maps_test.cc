// gluevo run --save-map and --load-map, gluevo localize and gluevo map as a user runs them.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

/// A flight through the hall, and the map that a run over its first half has made; once for all.
class MapsTest : public CommandTest {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder();
    const MapsTest program;
    const Outcome made = program.Run("simulate -o " + Flight() +
                                     " --path hall_loop --duration 14 --rate 4 --width 320 "
                                     "--height 240");
    ASSERT_EQ(made.exit_code, 0) << made.error;
    const Outcome run = program.Run("run " + Flight() + " --method klt --count 40 -o " +
                                    In("first") + " --save-map " + Map());
    ASSERT_EQ(run.exit_code, 0) << run.error;
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string In(const std::string& name) { return (folder_->path() / name).string(); }
  static std::string Flight() { return In("flight"); }
  static std::string Map() { return In("hall.map"); }

  static nlohmann::json Metrics(const std::string& folder) {
    std::ifstream file(fs::path(folder) / "metrics.json");
    return nlohmann::json::parse(file);
  }
  /// The rows of a table, by their fields.
  static std::vector<std::vector<std::string>> Rows(const std::string& folder) {
    std::ifstream file(fs::path(folder) / "localization.csv");
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("#") && !line.starts_with("#image")) {
        continue;
      }
      std::vector<std::string> fields(1);
      bool is_quoted = false;
      for (const char c : line) {
        if (c == '"') {
          is_quoted = !is_quoted;
        } else if (c == ',' && !is_quoted) {
          fields.emplace_back();
        } else {
          fields.back() += c;
        }
      }
      rows.push_back(fields);
    }
    return rows;
  }
  void TestBody() override {}

 private:
  static TemporaryFolder* folder_;
};

TemporaryFolder* MapsTest::folder_ = nullptr;

TEST_F(MapsTest, InfoSaysWhatAMapHolds) {
  const Outcome info = Run("map info " + Map());
  ASSERT_EQ(info.exit_code, 0) << info.error;
  for (const char* const part :
       {"superpoint", "built-in", "320 x 240", "parts: 1 (of segment 0: "}) {
    EXPECT_NE(info.out.find(part), std::string::npos) << info.out;
  }
  // Of ten seconds.
  EXPECT_NE(info.out.find("key frames: 2"), std::string::npos) << info.out;
}

TEST_F(MapsTest, FramesAreFoundInTheMap) {
  const std::string localize = "localize " + Flight() + " --map " + Map();
  const Outcome pairs = Run(localize + " --start 1 --stride 5 --count 8 -o " + Path("pairs"));
  ASSERT_EQ(pairs.exit_code, 0) << pairs.error;
  EXPECT_NE(pairs.out.find("found: 8 of 8 frames; ATE 0.0"), std::string::npos) << pairs.out;
  const auto rows = Rows(Path("pairs"));
  ASSERT_EQ(rows.size(), 9U);
  for (const auto& row : rows) {
    EXPECT_EQ(row.size(), 19U);
  }
  EXPECT_EQ(rows[1][2], "found");
  EXPECT_EQ(rows[1][3], "0");

  const Outcome lefts =
      Run(localize + " --left-only --start 1 --stride 9 --count 4 -o " + Path("lefts"));
  ASSERT_EQ(lefts.exit_code, 0) << lefts.error;
  EXPECT_NE(lefts.out.find("found: 4 of 4 frames; ATE 0.0"), std::string::npos) << lefts.out;
}

TEST_F(MapsTest, ImagesWithoutADataSetAreFoundToo) {
  const fs::path folder = Path("images");
  fs::create_directory(folder);
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(fs::path(Flight()) / "mav0" / "cam0" / "data")) {
    images.push_back(entry.path());
  }
  std::sort(images.begin(), images.end());
  for (const std::size_t i : {3, 20}) {
    fs::copy(images[i], folder / images[i].filename());
  }
  const Outcome outcome =
      Run("localize " + folder.string() + " --map " + Map() + " -o " + Path("out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(outcome.out.find("found: 2 of 2 frames"), std::string::npos) << outcome.out;
  EXPECT_EQ(Rows(Path("out"))[1][1], images[3].stem().string());

  // One that cannot be read is left out, and of the others the table says what it says of them.
  std::ofstream(folder / "0.png") << "no image";
  const Outcome broken =
      Run("localize " + folder.string() + " --map " + Map() + " -o " + Path("out"));
  ASSERT_EQ(broken.exit_code, 0) << broken.error;
  EXPECT_NE(broken.error.find("0.png"), std::string::npos) << broken.error;
  const auto rows = Rows(Path("out"));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[1][2], "left out");
  EXPECT_EQ(rows[1].size(), rows[0].size());
}

TEST_F(MapsTest, AnotherPlaceIsNotFound) {
  const Outcome made = Run("simulate -o " + Path("other") +
                           " --path hall_loop --duration 1 --rate 4 --width 320 --height 240 "
                           "--seed 7");
  ASSERT_EQ(made.exit_code, 0) << made.error;
  const Outcome outcome =
      Run("localize " + Path("other") + " --map " + Map() + " --count 3 -o " + Path("out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(outcome.out.find("found: 0 of 3"), std::string::npos) << outcome.out;
  const auto rows = Rows(Path("out"));
  EXPECT_EQ(rows[1][2], "not found");
  EXPECT_EQ(rows[1].size(), 19U);
}

TEST_F(MapsTest, ALaterRunGoesOnInIt) {
  const std::string run = "run " + Flight() + " --method klt --start 20 -o ";
  const Outcome later =
      Run(run + Path("later") + " --load-map " + Map() + " --save-map " + Path("grown.map"));
  ASSERT_EQ(later.exit_code, 0) << later.error;
  const nlohmann::json metrics = Metrics(Path("later"));
  EXPECT_EQ(metrics["frames_in_map"], metrics["frames"]);
  EXPECT_EQ(metrics["segments_joined"], 1);
  // Not those of the map.
  EXPECT_EQ(metrics["loops_closed"], metrics["loops"].size());
  EXPECT_EQ(metrics["options"]["loops"], "on");
  EXPECT_EQ(metrics["option_origins"]["loops"], "default");
  EXPECT_LT(metrics["optimized"]["ate_se3_m"], 0.05);
  // One map, of both runs.
  const Outcome info = Run("map info " + Path("grown.map"));
  EXPECT_NE(info.out.find("parts: 1 (of segment 0: "), std::string::npos) << info.out;
  EXPECT_EQ(info.out.find("; of segment"), std::string::npos) << info.out;

  // The same by two maps.
  ASSERT_EQ(Run(run + Path("second") + " --save-map " + Path("second.map")).exit_code, 0);
  const Outcome merged =
      Run("map merge " + Map() + " " + Path("second.map") + " -o " + Path("both.map"));
  ASSERT_EQ(merged.exit_code, 0) << merged.error;
  EXPECT_EQ(Run("map info " + Path("both.map")).out.find("key frames), "), std::string::npos);
  const Outcome exported = Run("map export " + Path("both.map") + " -o " + Path("export"));
  ASSERT_EQ(exported.exit_code, 0) << exported.error;
  for (const char* const name : {"points.ply", "keyframes.ply", "keyframes.tum"}) {
    EXPECT_TRUE(fs::is_regular_file(fs::path(Path("export")) / name)) << name;
  }
}

TEST_F(MapsTest, WhatDoesNotGoTogetherIsRefused) {
  const std::string run = "run " + Flight() + " --method klt --count 2 -o " + Path("out");
  const auto refuses = [&](const std::string& arguments, const std::string& what) {
    const Outcome outcome = Run(arguments);
    EXPECT_NE(outcome.exit_code, 0) << arguments;
    EXPECT_NE(outcome.error.find(what), std::string::npos) << outcome.error;
    EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1) << outcome.error;
  };
  refuses(run + " --loops off --save-map " + Path("a.map"), "--loops on");
  refuses(run + " --load-map " + Path("none.map"), "none.map");
  refuses(run + " --load-map " + Map() + " --save-map " + Map(), "is an input");
  const std::string notes = Write("notes.txt", "mine");
  refuses(run + " --save-map " + notes, "is not a map of gluevo");
  EXPECT_EQ(Contents(notes), "mine");
  refuses(run + " --load-map " + notes, "is no map");
  const std::string other = " --matcher nn --superpoint " GLUEVO_SOURCE_DIR
                            "/tests/data/weights/golden_superpoint_magic_leap.safetensors";
  refuses("localize " + Flight() + " --map " + Map() + other + " -o " + Path("out"),
          "golden_superpoint");
  refuses("map", "expected one of info, merge, export");
  refuses("map info", "gluevo map info --help");
  EXPECT_FALSE(fs::exists(Path("out")));
}

}  // namespace
}  // namespace gluevo::apps
