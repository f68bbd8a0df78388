// ALIKED and LightGlue in every command that takes networks, with random weights: what is chosen,
// found, written and refused. What the published ones find is not looked at here.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "apps/command_test.h"
#include "gluevo/nn/random_weights.h"

namespace gluevo::apps {
namespace {

using nlohmann::json;

class OpenNetworksTest : public CommandTest {
 protected:
  void SetUp() override { setenv("XDG_DATA_HOME", Path("home").c_str(), 1); }
  void TearDown() override { unsetenv("XDG_DATA_HOME"); }

  std::string Save(const std::string& name, nn::Weights weights,
                   const std::string& features = "") const {
    if (!features.empty()) {
      weights.metadata["features"] = features;
    }
    fs::create_directories(fs::path(Path(name)).parent_path());
    nn::WriteSafetensors(Path(name), weights);
    return Path(name);
  }
  std::string SaveAliked(const std::string& name) const {
    return Save(name, nn::RandomAlikedWeights({4, 6, 8, 10}, 64, 3));
  }
  std::string SaveLightGlue(const std::string& name, const std::string& features = "") const {
    return Save(name, nn::RandomLightGlueWeights(3, 64, 32, 2), features);
  }
  // As gluevo-weights get leaves them.
  void FillOwnFolder() const {
    SaveAliked("home/gluevo/weights/aliked-n16.safetensors");
    SaveLightGlue("home/gluevo/weights/lightglue-aliked.safetensors", "aliked");
  }
  // Views of a random mosaic, each 2 pixels to the right of the one before, and 6 more to the right
  // in the right camera; KITTI's layout.
  fs::path MakeKitti() const {
    fs::path root = fs::path(Path("data")) / "sequences" / "00";
    std::mt19937 generator(5);
    cv::Mat texture(96, 220, CV_8UC1);
    for (int y = 0; y < texture.rows; ++y) {
      for (int x = 0; x < texture.cols; ++x) {
        texture.at<uchar>(y, x) = y % 4 == 0 && x % 4 == 0
                                      ? static_cast<uchar>(generator() % 256)
                                      : texture.at<uchar>(y / 4 * 4, x / 4 * 4);
      }
    }
    std::string times;
    for (const int side : {0, 1}) {
      const fs::path folder = root / ("image_" + std::to_string(side));
      fs::create_directories(folder);
      for (int i = 0; i < 3; ++i) {
        cv::imwrite((folder / ("00000" + std::to_string(i) + ".png")).string(),
                    texture(cv::Rect(20 + 2 * i + 6 * side, 0, 160, 96)));
      }
    }
    std::ofstream(root / "times.txt") << "0\n0.1\n0.2\n";
    std::ofstream(root / "calib.txt") << "P0: 100 0 80 0 0 100 48 0 0 0 1 0\n"
                                         "P1: 100 0 80 -50 0 100 48 0 0 0 1 0\n";
    return root;
  }
  // One line that says this.
  void ExpectRefused(const std::string& arguments, const std::string& expected,
                     int exit_code = 1) const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code);
    const std::size_t message = outcome.error.find("gluevo: error: ");
    ASSERT_NE(message, std::string::npos) << outcome.error;
    const std::string line = outcome.error.substr(message);
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
    EXPECT_NE(line.find(expected), std::string::npos) << line;
  }
  // With results in outTHREADS and matches in mTHREADS.h5.
  Outcome RunOn(const std::string& threads, std::string run) const {
    run.append(" --threads ").append(threads);
    run.append(" -o ").append(Path("out" + threads));
    return Run(run.append(" --save-matches ").append(Path("m" + threads + ".h5")));
  }
  json Metrics(const std::string& folder) const {
    return json::parse(Contents(Path(folder + "/metrics.json")));
  }
};

TEST_F(OpenNetworksTest, LackOfWeightsIsOneLine) {
  const std::string root = MakeKitti().string();
  const std::string images = root + "/image_0";
  const std::string pair = images + "/000000.png " + images + "/000001.png";
  const std::string lack =
      "--features aliked needs weights: run gluevo-weights get aliked-n16, or name a file with "
      "--aliked\n";
  ExpectRefused("run " + root + " -o " + Path("out") + " --features aliked", lack);
  ExpectRefused("extract " + images + " -o " + Path("f.h5") + " --features aliked", lack);
  ExpectRefused("match " + pair + " --features aliked", lack);
  ExpectRefused("bench --network aliked", lack);
  ExpectRefused("bench --network lightglue", "run gluevo-weights get lightglue-aliked");
  EXPECT_FALSE(fs::exists(Path("out")));
  EXPECT_FALSE(fs::exists(Path("f.h5")));
}

TEST_F(OpenNetworksTest, RunTakesThemAndItsRecordsSayWhich) {
  FillOwnFolder();
  const std::string run =
      "run " + MakeKitti().string() + " --features aliked --keypoint-threshold 0";
  for (const std::string matcher : {"lightglue", "nn"}) {
    SCOPED_TRACE(matcher);
    const std::string options = matcher == "nn" ? " --matcher nn" : "";
    for (const std::string threads : {"1", "2"}) {
      // Random networks need not track anything: then exit code 1, all outputs there.
      EXPECT_LE(RunOn(threads, run + options).exit_code, 1);
    }
    EXPECT_EQ(Contents(Path("out1/trajectory.tum")), Contents(Path("out2/trajectory.tum")));
    const json metrics = Metrics("out1");
    EXPECT_EQ(metrics["method"], "superglue");
    EXPECT_EQ(metrics["features"], "aliked");
    EXPECT_EQ(metrics["matcher"], matcher);
    EXPECT_EQ(metrics["weights"].size(), matcher == "nn" ? 1U : 2U);
    EXPECT_EQ(metrics["weights"]["aliked"]["name"],
              Path("home/gluevo/weights/aliked-n16.safetensors"));
    EXPECT_EQ(metrics["weights"].contains("lightglue"), matcher == "lightglue");
    EXPECT_TRUE(metrics["stages_ms"].contains("aliked"));
    EXPECT_FALSE(metrics["stages_ms"].contains("superpoint"));
    EXPECT_EQ(metrics["options"]["matcher"], matcher);
    EXPECT_EQ(metrics["options"]["refine"], "none");
    EXPECT_EQ(metrics["option_origins"]["refine"], "method");
    EXPECT_EQ(metrics["options"]["max-keypoints"], "500");
    EXPECT_EQ(metrics["options"]["tracking-threshold"], matcher == "nn" ? "0.2" : "0.1");
    EXPECT_EQ(metrics["options"]["depth-confidence"], "0.95");
    EXPECT_NE(Contents(Path("out1/report.html")).find("ALIKED"), std::string::npos);

    // A replay knows by the stored matches, and needs no weights.
    fs::rename(Path("home"), Path("hidden"));
    EXPECT_LE(
        Run("run " + MakeKitti().string() + " --replay " + Path("m1.h5") + " -o " + Path("again"))
            .exit_code,
        1);
    fs::rename(Path("hidden"), Path("home"));
    const json again = Metrics("again");
    for (const char* const key : {"method", "features", "matcher", "weights"}) {
      EXPECT_EQ(again[key], metrics[key]) << key;
    }
    EXPECT_EQ(Contents(Path("out1/trajectory.tum")), Contents(Path("again/trajectory.tum")));
  }
}

TEST_F(OpenNetworksTest, MethodOneTakesAlikedAndOtherMethodsSayWhatTheyHave) {
  FillOwnFolder();
  const std::string run = "run " + MakeKitti().string() + " -o " + Path("out");
  EXPECT_LE(Run(run + " --method superpoint --features aliked").exit_code, 1);
  json metrics = Metrics("out");
  EXPECT_EQ(metrics["method"], "superpoint");
  EXPECT_EQ(metrics["features"], "aliked");
  EXPECT_FALSE(metrics.contains("matcher"));
  EXPECT_EQ(metrics["options"]["refine"], "lk");
  EXPECT_EQ(metrics["options"]["max-keypoints"], "1500");
  EXPECT_EQ(metrics["weights"].size(), 1U);

  EXPECT_LE(Run(run + " --method klt").exit_code, 1);
  metrics = Metrics("out");
  EXPECT_FALSE(metrics.contains("features"));
  EXPECT_FALSE(metrics.contains("matcher"));

  EXPECT_LE(Run(run).exit_code, 1);
  metrics = Metrics("out");
  EXPECT_EQ(metrics["features"], "superpoint");
  EXPECT_EQ(metrics["matcher"], "superglue");
  EXPECT_EQ(metrics["options"]["matcher"], "superglue");
  EXPECT_EQ(metrics["option_origins"]["matcher"], "default");
  EXPECT_EQ(metrics["options"]["refine"], "lk");
}

TEST_F(OpenNetworksTest, PairsThatDoNotFitAreRefusedByName) {
  const std::string root = MakeKitti().string();
  const std::string aliked = SaveAliked("a.safetensors");
  const std::string lightglue = SaveLightGlue("l.safetensors");
  const std::string run = "run " + root + " -o " + Path("out") + " ";
  const std::string both = "--features aliked --aliked " + aliked + " --lightglue ";
  ExpectRefused(run + "--features aliked --matcher superglue", "expected lightglue or nn", 2);
  ExpectRefused(run + "--features aliked --refine subpixel", "option refine is \"subpixel\"", 2);
  ExpectRefused(run + "--aliked " + aliked, "expected --features aliked", 2);
  ExpectRefused(run + both + SaveLightGlue("d.safetensors", "disk"), "trained on \"disk\"");
  const std::string wide = Save("w.safetensors", nn::RandomLightGlueWeights(2, 128, 32, 2));
  ExpectRefused(run + both + wide,
                "a LightGlue for descriptors of 128 values cannot match those of " + aliked);
  ExpectRefused(run + "--features aliked --aliked " + lightglue, lightglue);
  ExpectRefused(run + both + aliked, "these are an ALIKED's");
  ExpectRefused(
      run + "--matcher lightglue --lightglue " + lightglue,
      "a LightGlue for descriptors of 64 values cannot match those of built-in superpoint");
  EXPECT_FALSE(fs::exists(Path("out")));
  // A folder with two that could be meant.
  SaveAliked("folder/aliked-n32.safetensors");
  SaveAliked("folder/aliked-t16.safetensors");
  ExpectRefused(run + "--features aliked --weights " + Path("folder"), "name one with --aliked");
}

TEST_F(OpenNetworksTest, ExtractAndMatch) {
  FillOwnFolder();
  const std::string images = MakeKitti().string() + "/image_0";
  ASSERT_EQ(Run("extract " + images +
                " --features aliked --keypoint-threshold 0 --max-keypoints "
                "40 -o " +
                Path("f.h5"))
                .exit_code,
            0);
  const std::string pairs = Write("pairs.txt", "000000.png 000001.png\n");
  const std::string match =
      "match " + Path("f.h5") + " --pairs " + pairs + " -o " + Path("m.h5") + " ";
  for (const std::string& options :
       {std::string("--features aliked"), std::string("--matcher lightglue"),
        std::string("--features aliked --matcher nn"),
        "--matcher lightglue --lightglue " + SaveLightGlue("d.safetensors", "disk")}) {
    const Outcome outcome = Run(match + options);
    EXPECT_EQ(outcome.exit_code, 0) << options << outcome.error;
    EXPECT_EQ(outcome.out.substr(0, 8), "1 pair, ") << outcome.out;
  }
  // SuperGlue is for others.
  ExpectRefused(match, "f.h5: pair \"000000.png\", \"000001.png\": descriptors of 64 values");

  const std::string two = "match " + images + "/000000.png " + images + "/000001.png --json ";
  const Outcome outcome = Run(two +
                              "--features aliked --keypoint-threshold 0 --max-keypoints 30 "
                              "--match-threshold 0");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  const json result = json::parse(outcome.out);
  EXPECT_GT(result["keypoints0"], 10);
  EXPECT_LE(result["keypoints0"], 30);
  // Which threshold of scores suits is the features' own matter: here all are about a half.
  const json all = json::parse(Run(two + "--features aliked --matcher nn").out);
  EXPECT_GT(all["keypoints0"], 0);
}

TEST_F(OpenNetworksTest, BenchRunsThem) {
  FillOwnFolder();
  const auto bench = [&](const std::string& options) {
    const Outcome outcome = Run("bench --rounds 2 --size 96x64 --keypoints 20 --json " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    return json::parse(outcome.out, nullptr, /*allow_exceptions=*/false);
  };
  const json aliked = bench("--network aliked --output " + Path("a.out"));
  EXPECT_EQ(aliked["weights"], Path("home/gluevo/weights/aliked-n16.safetensors"));
  EXPECT_EQ(aliked["keypoints"], 20);
  EXPECT_FALSE(aliked.contains("layers"));
  EXPECT_EQ(nn::ReadWeights(Path("a.out")).Get("descriptors").shape(), (nn::Shape{20, 64}));
  EXPECT_EQ(nn::ReadWeights(Path("a.out")).Get("score_map").shape(), (nn::Shape{64, 96}));

  const json lightglue =
      bench("--network lightglue --depth-confidence 0 --output " + Path("l.out"));
  EXPECT_EQ(lightglue["layers"], 3);
  EXPECT_EQ(nn::ReadWeights(Path("l.out")).Get("log_assignment").shape(), (nn::Shape{21, 21}));
  EXPECT_EQ(bench("--network lightglue --layers 2")["layers"], 2);
  EXPECT_EQ(bench("--network aliked --layers 1")["weights"], "random weights");
  EXPECT_EQ(Run("bench --network aliked --features f.h5").exit_code, 2);
  EXPECT_EQ(Run("bench --network lightglue --image a.png").exit_code, 2);
  EXPECT_EQ(Run("bench --network lightglue --layers 2 --lightglue l").exit_code, 2);
}

TEST_F(OpenNetworksTest, WeightsListsWhatIsHereAndWhatTakesIt) {
  const Outcome none = Run("weights");
  ASSERT_EQ(none.exit_code, 0) << none.error;
  for (const std::string text : {"built in\n", "superglue, 6 layers, descriptors of 256",
                                 "licence: Apache-2.0", "gluevo-weights get aliked-n16"}) {
    EXPECT_NE(none.out.find(text), std::string::npos) << text << "\n" << none.out;
  }
  FillOwnFolder();
  const std::string own = "home/gluevo/weights/";
  SaveAliked(own + "aliked-n32.safetensors");
  SaveLightGlue(own + "lightglue-disk.safetensors", "disk");
  Write(own + "broken.safetensors", "broken");
  Write(own + "notes.txt", "");
  const Outcome outcome = Run("weights");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  for (const std::string& text :
       {std::string("aliked-n16.safetensors: aliked, descriptors of 64\n    licence: not stated\n"
                    "    taken by --features aliked\n"),
        "aliked-n32.safetensors: aliked, descriptors of 64\n    licence: not stated\n"
        "    taken by --features aliked --aliked " +
            Path(own + "aliked-n32.safetensors") + "\n",
        std::string("lightglue-aliked.safetensors: lightglue, 3 layers, descriptors of 64\n    "
                    "licence: not stated\n    taken by --features aliked\n"),
        "--matcher lightglue --lightglue " + Path(own + "lightglue-disk.safetensors") +
            ", for features of disk",
        std::string("broken.safetensors: cannot be used: ")}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << "\n" << outcome.out;
  }
  EXPECT_EQ(outcome.out.find("notes.txt"), std::string::npos);
}

TEST_F(OpenNetworksTest, ExperimentsNameTheirFiles) {
  MakeKitti();
  SaveAliked("a.safetensors");
  SaveLightGlue("l.safetensors");
  const std::string list = Write(
      "list.yaml",
      "data: [{name: drive, path: data/sequences/00}]\n"
      "methods:\n  - {name: open, method: superglue, features: aliked, aliked: a.safetensors, "
      "lightglue: l.safetensors, keypoint-threshold: 0}\n");
  const Outcome plan = Run("experiment " + list + " -o " + Path("results") + " --dry-run");
  ASSERT_EQ(plan.exit_code, 0) << plan.error;
  // Paths are relative to the list.
  EXPECT_NE(plan.out.find("--aliked " + Path("a.safetensors")), std::string::npos) << plan.out;
  EXPECT_NE(plan.out.find("--lightglue " + Path("l.safetensors")), std::string::npos) << plan.out;
}

}  // namespace
}  // namespace gluevo::apps
