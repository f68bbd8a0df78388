#include "gluevo/nn/superglue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "nn/golden.h"

namespace gluevo::nn {
namespace {

Features GoldenFeatures(const Weights& golden, const std::string& image) {
  Features features;
  features.width = static_cast<int>(golden.Get("size" + image)[0]);
  features.height = static_cast<int>(golden.Get("size" + image)[1]);
  features.keypoints = golden.Get("keypoints" + image).Matrix();
  features.scores = golden.Get("scores" + image).view().Vector();
  features.descriptors = golden.Get("descriptors" + image).Matrix();
  return features;
}

Weights WeightsOf(const std::string& golden_name) {
  return golden_name == "golden_superglue_open" ? OpenSuperGlueWeights()
                                                : ReadGolden("superglue_tiny_weights");
}

class SuperGlueGolden : public testing::TestWithParam<std::pair<Isa, const char*>> {};

TEST_P(SuperGlueGolden, AssignmentAndMatchesAgree) {
  const auto& [isa, name] = GetParam();
  const Weights golden = ReadGolden(name);
  const Features features0 = GoldenFeatures(golden, "0");
  const Features features1 = GoldenFeatures(golden, "1");
  const SuperGlue network(WeightsOf(name), Precision::kFloat, isa);
  ThreadPool pool(2);
  Workspace workspace(pool);

  const SuperGlueOptions options = {
      .match_threshold = std::string(name) == "golden_superglue_open" ? 0.2F : 0.05F};
  const TensorView<float> log_assignment =
      network.LogAssignment(features0, features1, options, workspace);
  const auto expected = golden.Get("log_assignment").Matrix();
  CheckShape(log_assignment.shape(), golden.Get("log_assignment").shape(), "log assignment");
  EXPECT_LT(RelativeRms(log_assignment.Matrix(), expected), kNetworkTolerance);

  Matches matches;
  network.Match(features0, features1, options, workspace, matches);
  for (int i = 0; i < features0.size(); ++i) {
    EXPECT_EQ(matches.matches0[i], static_cast<int>(golden.Get("matches0")[i])) << i;
    // The confidence is the exponential of a value that errs absolutely.
    EXPECT_NEAR(matches.scores0[i], golden.Get("matching_scores0")[i],
                kNetworkTolerance * expected.cwiseAbs().maxCoeff());
  }
}

// The rounding of operands to 8 bits errs by at most 2^-9 of each, independently; a token has gone
// through about five products a layer, whose errors add up like a random walk.
TEST_P(SuperGlueGolden, Bf16IsCloseToTheExactAssignment) {
  const auto& [isa, name] = GetParam();
  const Weights golden = ReadGolden(name);
  const Features features0 = GoldenFeatures(golden, "0");
  const Features features1 = GoldenFeatures(golden, "1");
  const SuperGlue network(WeightsOf(name), Precision::kBf16, isa);
  ThreadPool pool(2);
  Workspace workspace(pool);
  const TensorView<float> log_assignment =
      network.LogAssignment(features0, features1, {}, workspace);
  const double tolerance = 0x1p-9 * std::sqrt(5.0 * network.layers());
  const double error = RelativeRms(log_assignment.Matrix(), golden.Get("log_assignment").Matrix());
  EXPECT_LT(error, tolerance);
  // Floats would be much closer: that bf16 ran at all.
  EXPECT_GT(error, kNetworkTolerance);
}

std::vector<std::pair<Isa, const char*>> AllGolden() {
  std::vector<std::pair<Isa, const char*>> all;
  for (const Isa isa : SupportedIsas()) {
    for (const char* const name :
         {"golden_superglue_open", "golden_superglue_tiny_13x22", "golden_superglue_tiny_1x3"}) {
      all.emplace_back(isa, name);
    }
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Isas, SuperGlueGolden, testing::ValuesIn(AllGolden()),
                         [](const auto& test) {
                           return IsaName(test.param.first) +
                                  std::string(test.param.second).substr(16);
                         });

TEST(SuperGlueTest, IsTheSameForAnyNumberOfThreads) {
  const Weights golden = ReadGolden("golden_superglue_open");
  for (const Precision precision : {Precision::kFloat, Precision::kBf16}) {
    const SuperGlue network(OpenSuperGlueWeights(), precision);
    std::vector<Matches> results;
    for (const int threads : {1, 2, 3, 5}) {
      ThreadPool pool(threads);
      Workspace workspace(pool);
      network.Match(GoldenFeatures(golden, "0"), GoldenFeatures(golden, "1"), {}, workspace,
                    results.emplace_back());
      EXPECT_EQ(results.back().matches0, results[0].matches0);
      EXPECT_EQ(results.back().scores0, results[0].scores0);
    }
  }
}

TEST(SuperGlueTest, EmptySetsHaveNoMatches) {
  const Features features = GoldenFeatures(ReadGolden("golden_superglue_open"), "0");
  Features empty;
  empty.width = 120;
  empty.height = 88;
  const SuperGlue network(OpenSuperGlueWeights());
  ThreadPool pool(1);
  Workspace workspace(pool);
  Matches matches;
  network.Match(features, empty, {}, workspace, matches);
  EXPECT_EQ(matches.matches0, std::vector<int>(features.size(), -1));
  network.Match(empty, features, {}, workspace, matches);
  EXPECT_TRUE(matches.matches0.empty());
}

TEST(SuperGlueTest, RefusesDescriptorsOfAnotherNetwork) {
  Features features = GoldenFeatures(ReadGolden("golden_superglue_open"), "0");
  features.descriptors.conservativeResize(Eigen::NoChange, 128);
  const SuperGlue network(OpenSuperGlueWeights());
  ThreadPool pool(1);
  Workspace workspace(pool);
  Matches matches;
  try {
    network.Match(features, features, {}, workspace, matches);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("descriptors of 128 values"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("a SuperGlue of 256"), std::string::npos);
  }
}

// Such as SuperPoint::Describe leaves them.
TEST(SuperGlueTest, RefusesKeypointsWithoutScores) {
  const Features features = GoldenFeatures(ReadGolden("golden_superglue_open"), "0");
  Features described = features;
  described.scores.resize(0);
  const SuperGlue network(OpenSuperGlueWeights());
  ThreadPool pool(1);
  Workspace workspace(pool);
  Matches matches;
  try {
    network.Match(features, described, {}, workspace, matches);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("keypoints with 0 scores"), std::string::npos)
        << error.what();
  }
}

TEST(SuperGlueTest, RefusesOtherWeightsAndShapesThatDoNotFit) {
  EXPECT_THROW(SuperGlue{OpenSuperPointWeights()}, Error);
  Weights weights = ReadGolden("superglue_tiny_weights");
  weights.tensors["final_proj.weight"] = Tensor<float>(Shape{32, 16, 1});
  try {
    const SuperGlue network(weights);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("final_proj.weight has shape [32 x 16 x 1]"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace gluevo::nn
