#include "gluevo/nn/lightglue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "gluevo/nn/random_weights.h"
#include "lightglue_network.h"
#include "nn/golden.h"
#include "nn/oracle_file.h"
#include "nn/plain_lightglue.h"

namespace gluevo::nn {
namespace {

Features RandomFeatures(int count, int size, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform;
  Features features;
  features.width = 320;
  features.height = 200;
  features.keypoints.resize(count, 2);
  features.descriptors.resize(count, size);
  for (int i = 0; i < count; ++i) {
    features.keypoints(i, 0) = 320.0F * uniform(generator);
    features.keypoints(i, 1) = 200.0F * uniform(generator);
    for (int j = 0; j < size; ++j) {
      features.descriptors(i, j) = normal(generator);
    }
    features.descriptors.row(i).normalize();
  }
  return features;
}

// The same descriptors in another order, a little changed, so that there is something to match.
Features Shuffled(const Features& from, float noise, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<float> normal;
  std::vector<int> order(static_cast<std::size_t>(from.size()));
  for (int i = 0; i < from.size(); ++i) {
    order[static_cast<std::size_t>(i)] = i;
  }
  std::shuffle(order.begin(), order.end(), generator);
  Features features = from;
  for (int i = 0; i < from.size(); ++i) {
    features.keypoints.row(i) = from.keypoints.row(order[static_cast<std::size_t>(i)]);
    features.descriptors.row(i) = from.descriptors.row(order[static_cast<std::size_t>(i)]);
    for (Eigen::Index j = 0; j < from.descriptors.cols(); ++j) {
      features.descriptors(i, j) += noise * normal(generator);
    }
    features.descriptors.row(i).normalize();
  }
  return features;
}

// Rows of an image's tokens, from their blocks.
Features::RowMajor TokensOf(const LightGlueImage& image, int64_t size) {
  Features::RowMajor tokens(image.count, size);
  for (int64_t row = 0; row < image.count; ++row) {
    for (int64_t c = 0; c < size; ++c) {
      tokens(row, c) = image.tokens[c / kernels::kBlock * image.stride + row * kernels::kBlock +
                                    c % kernels::kBlock];
    }
  }
  return tokens;
}

constexpr LightGlueOptions kEverything = {.depth_confidence = 0.0F, .width_confidence = 0.0F};

struct Sizes {
  int layers, descriptor, token, heads;
};

class LightGlueIsas : public testing::TestWithParam<Isa> {};

INSTANTIATE_TEST_SUITE_P(Isas, LightGlueIsas, testing::ValuesIn(SupportedIsas()),
                         [](const auto& test) { return IsaName(test.param); });

// Published sizes and odd ones: heads that fill no whole blocks, LighterGlue's single head of 96.
TEST_P(LightGlueIsas, TokensAndAssignmentAreThoseOfThePlainNetwork) {
  for (const Sizes& sizes :
       {Sizes{2, 128, 256, 4}, {2, 64, 96, 1}, {3, 24, 24, 2}, {1, 40, 80, 2}}) {
    SCOPED_TRACE(testing::Message() << sizes.token << " in " << sizes.heads << " heads");
    const Weights weights =
        RandomLightGlueWeights(sizes.layers, sizes.descriptor, sizes.token, sizes.heads);
    const PlainLightGlue plain(weights);
    const LightGlueNetwork network(ReadLightGlueWeights(weights), GetParam());
    ThreadPool pool(2);
    Workspace workspace(pool);
    const Features features0 = RandomFeatures(37, sizes.descriptor, 1);
    const Features features1 = RandomFeatures(18, sizes.descriptor, 2);
    for (int blocks = 0; blocks <= 2 * sizes.layers; ++blocks) {
      const auto [x0, x1] = plain.Tokens(features0, features1, blocks);
      workspace.arena.Reset();
      const LightGlueState state =
          network.Run(features0, features1, kEverything, blocks, workspace);
      EXPECT_LT(RelativeRms(TokensOf(state.images[0], sizes.token), x0), kNetworkTolerance);
      EXPECT_LT(RelativeRms(TokensOf(state.images[1], sizes.token), x1), kNetworkTolerance);
      EXPECT_EQ(state.layers, blocks / 2);
    }
    const auto [x0, x1] = plain.Tokens(features0, features1, 2 * sizes.layers);
    const LightGlue lightglue(weights, GetParam());
    const TensorView<float> assignment = lightglue.LogAssignment(features0, features1, workspace);
    EXPECT_LT(RelativeRms(assignment.Matrix(), plain.LogAssignment(x0, x1, sizes.layers - 1)),
              kNetworkTolerance);
  }
}

TEST_P(LightGlueIsas, MatchesAreTheMutualBestOfTheAssignment) {
  const Weights weights = RandomLightGlueWeights(2, 128, 64, 2);
  const LightGlue lightglue(weights, GetParam());
  ThreadPool pool(2);
  Workspace workspace(pool);
  const Features features0 = RandomFeatures(40, 128, 1);
  const Features features1 = Shuffled(features0, 0.02F, 3);
  Matches matches;
  LightGlueOptions options = kEverything;
  options.match_threshold = 1e-4F;
  LightGlueEffort effort;
  lightglue.Match(features0, features1, options, workspace, matches, &effort);
  EXPECT_EQ(effort.layers, 2);
  EXPECT_EQ(effort.rounds0, std::vector<int>(40, 1));
  const Features::RowMajor inner =
      lightglue.LogAssignment(features0, features1, workspace).Matrix().topLeftCorner(40, 40);
  int count = 0;
  for (int i = 0; i < 40; ++i) {
    Eigen::Index best = 0;
    Eigen::Index back = 0;
    const float log_score = inner.row(i).maxCoeff(&best);
    inner.col(best).maxCoeff(&back);
    const bool matched = back == i && std::exp(log_score) > options.match_threshold;
    EXPECT_EQ(matches.matches0[i], matched ? static_cast<int>(best) : -1);
    EXPECT_FLOAT_EQ(matches.scores0[i], matched ? std::exp(log_score) : 0.0F);
    count += matched ? 1 : 0;
  }
  EXPECT_GT(count, 5);
}

// The first layer is made sure of everything, or of all but a few.
Weights WithConfidence(Weights weights, float bias) {
  weights.tensors.at("token_confidence.0.token.0.weight").view().Vector().setZero();
  weights.tensors.at("token_confidence.0.token.0.bias")[0] = bias;
  return weights;
}

TEST(LightGlueTest, StopsOnceItIsSure) {
  ThreadPool pool(2);
  Workspace workspace(pool);
  const Features features0 = RandomFeatures(20, 128, 1);
  const Features features1 = RandomFeatures(30, 128, 2);
  Matches matches;
  LightGlueEffort effort;
  LightGlueOptions options = {.width_confidence = 0.0F};
  // sigmoid(2.3) is above the first layer's 0.9, sigmoid(2.1) below.
  for (const auto& [bias, layers] : {std::pair(2.3F, 1), {2.1F, 3}}) {
    Weights weights = WithConfidence(RandomLightGlueWeights(3, 128, 64, 2), bias);
    weights.tensors.at("token_confidence.1.token.0.bias")[0] = -20.0F;
    const LightGlue lightglue(weights);
    lightglue.Match(features0, features1, options, workspace, matches, &effort);
    EXPECT_EQ(effort.layers, layers) << bias;
  }
}

// Keypoints leave that have no match, unless they are not sure of it.
TEST(LightGlueTest, KeypointsThatLeaveAreNotMatched) {
  Weights weights = WithConfidence(RandomLightGlueWeights(3, 128, 64, 2), -5.0F);
  // Unmatchable where the second value of a token is negative: the logit is a thousand times it.
  Tensor<float>& matchability = weights.tensors.at("log_assignment.0.matchability.weight");
  matchability.view().Vector().setZero();
  matchability[1] = 1000.0F;
  weights.tensors.at("log_assignment.0.matchability.bias")[0] = 0.0F;
  weights.tensors.at("log_assignment.1.matchability.bias")[0] = 50.0F;  // None leaves later.
  ThreadPool pool(2);
  Workspace workspace(pool);
  const Features features0 = RandomFeatures(50, 128, 1);
  const Features features1 = Shuffled(features0, 0.02F, 3);
  const PlainLightGlue plain(weights);
  const auto [x0, x1] = plain.Tokens(features0, features1, 2);
  const LightGlue lightglue(weights);
  Matches matches;
  LightGlueEffort effort;
  LightGlueOptions options = {.match_threshold = 1e-5F, .depth_confidence = 0.0F};
  lightglue.Match(features0, features1, options, workspace, matches, &effort);
  EXPECT_EQ(effort.layers, 3);
  int left = 0;
  for (int i = 0; i < 50; ++i) {
    const bool stays = x0(i, 1) > 0.0;
    EXPECT_EQ(effort.rounds0[i], stays ? 3 : 1) << i;
    EXPECT_TRUE(stays || matches.matches0[i] < 0);
    left += stays ? 0 : 1;
    if (matches.matches0[i] >= 0) {
      EXPECT_GT(x1(matches.matches0[i], 1), 0.0);
    }
  }
  EXPECT_GT(left, 5);
  EXPECT_LT(left, 45);

  // With adaptive depth it counts that none is sure.
  options.depth_confidence = 0.95F;
  lightglue.Match(features0, features1, options, workspace, matches, &effort);
  EXPECT_GE(*std::min_element(effort.rounds0.begin(), effort.rounds0.end()), 2);
}

TEST(LightGlueTest, IsTheSameForAnyNumberOfThreads) {
  const LightGlue lightglue(RandomLightGlueWeights(3));
  const Features features0 = RandomFeatures(130, 128, 1);
  const Features features1 = Shuffled(features0, 0.02F, 3);
  const LightGlueOptions options = {.match_threshold = 1e-4F, .width_confidence = 0.5F};
  std::vector<Matches> results;
  for (const int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    Workspace workspace(pool);
    lightglue.Match(features0, features1, options, workspace, results.emplace_back());
    EXPECT_EQ(results.back().matches0, results[0].matches0);
    EXPECT_EQ(results.back().scores0, results[0].scores0);
  }
}

TEST(LightGlueTest, EmptySetsHaveNoMatches) {
  const LightGlue lightglue(RandomLightGlueWeights(1));
  const Features features = RandomFeatures(5, 128, 1);
  Features empty;
  empty.width = 120;
  empty.height = 88;
  ThreadPool pool(1);
  Workspace workspace(pool);
  Matches matches;
  const LightGlueOptions options;
  lightglue.Match(features, empty, options, workspace, matches);
  EXPECT_EQ(matches.matches0, std::vector<int>(5, -1));
  lightglue.Match(empty, features, options, workspace, matches);
  EXPECT_TRUE(matches.matches0.empty());
}

template <typename Call>
void ExpectError(const Call& call, const std::string& text) {
  try {
    call();
    FAIL() << text;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(LightGlueTest, RefusesWhatDoesNotBelongToIt) {
  const LightGlue lightglue(RandomLightGlueWeights(1, 32, 64, 2));
  ThreadPool pool(1);
  Workspace workspace(pool);
  Matches matches;
  const Features features = RandomFeatures(5, 48, 1);
  ExpectError([&] { lightglue.Match(features, features, {}, workspace, matches); },
              "descriptors of 48 values cannot be matched by a LightGlue of 32");
  ExpectError([&] { LightGlue{OpenSuperGlueWeights()}; }, "these are a SuperGlue's");

  Weights weights = RandomLightGlueWeights(2, 32, 64, 2);
  weights.tensors["transformers.1.self_attn.Wqkv.weight"] = Tensor<float>(Shape{64, 64});
  ExpectError([&] { LightGlue{weights}; },
              "\"transformers.1.self_attn.Wqkv.weight\" has shape [64 x 64]");
  weights = RandomLightGlueWeights(2, 32, 64, 2);
  weights.tensors["posenc.Wr.weight"] = Tensor<float>(Shape{16, 4});
  ExpectError([&] { LightGlue{weights}; }, "posenc.Wr.weight has shape [16 x 4]");
  weights.tensors["posenc.Wr.weight"] = Tensor<float>(Shape{15, 2});
  ExpectError([&] { LightGlue{weights}; }, "do not divide into heads of 30");
  weights = RandomLightGlueWeights(2, 32, 64, 2);
  weights.tensors.erase("token_confidence.0.token.0.weight");
  const LightGlue unsure(weights);
  EXPECT_FALSE(unsure.has_adaptive_depth());
  const Features right = RandomFeatures(5, 32, 1);
  ExpectError([&] { unsure.Match(right, right, {}, workspace, matches); },
              "depth confidence must be 0");
  ExpectError([] { LightGlueOptions{.width_confidence = 1.0F}.Validate(); }, "width confidence");
}

class LightGlueOracle : public testing::TestWithParam<Isa> {
 protected:
  void SetUp() override {
    const auto lightglue = OraclePath("lightglue");
    const auto aliked = OraclePath("aliked-n16");
    const auto weights = PublishedWeightsPath("lightglue-aliked");
    if (!lightglue || !aliked || !weights) {
      GTEST_SKIP() << "needs oracle_open and lightglue-aliked.safetensors in the folder of "
                      "GLUEVO_PUBLISHED_WEIGHTS";
    }
    oracle_ = std::make_unique<OracleFile>(*lightglue);
    weights_ = ReadWeights(*weights);
    const OracleFile points(*aliked);
    for (int i = 0; i < 2; ++i) {
      const std::string image = "image" + std::to_string(i) + "_";
      features_[i].width = static_cast<int>(points.Floats(image + "size")[0]);
      features_[i].height = static_cast<int>(points.Floats(image + "size")[1]);
      features_[i].keypoints = points.Floats(image + "keypoints").Matrix();
      features_[i].descriptors = points.Floats(image + "descriptors").Matrix();
    }
  }

  double LargestError(const Features::RowMajor& actual, const std::string& name) const {
    return (actual.cast<double>() - oracle_->Floats(name).Matrix().cast<double>())
        .cwiseAbs()
        .maxCoeff();
  }

  void CheckMatches(const std::string& run, const LightGlueOptions& options) {
    SCOPED_TRACE(run);
    const LightGlue lightglue(weights_, GetParam());
    Workspace workspace(pool_);
    Matches matches;
    LightGlueEffort effort;
    lightglue.Match(features_[0], features_[1], options, workspace, matches, &effort);
    const std::vector<int64_t>& pairs = oracle_->Integers(run + "_matches");
    const Tensor<float>& scores = oracle_->Floats(run + "_scores");
    std::vector<int> expected(matches.matches0.size(), -1);
    for (std::size_t k = 0; 2 * k < pairs.size(); ++k) {
      const auto i = static_cast<std::size_t>(pairs[2 * k]);
      expected[i] = static_cast<int>(pairs[2 * k + 1]);
      EXPECT_NEAR(matches.scores0[i], scores[static_cast<int64_t>(k)], 5e-4);
    }
    EXPECT_EQ(matches.matches0, expected);
    EXPECT_EQ(effort.layers, oracle_->Integers(run + "_stop")[0]);
    if (options.width_confidence > 0.0F) {
      const auto numbers = [&](const std::string& name) {
        const std::vector<int64_t>& values = oracle_->Integers(name);
        return std::vector<int>(values.begin(), values.end());
      };
      EXPECT_EQ(effort.rounds0, numbers(run + "_prune0"));
      EXPECT_EQ(effort.rounds1, numbers(run + "_prune1"));
    }
  }

  ThreadPool pool_{2};
  std::unique_ptr<OracleFile> oracle_;
  Weights weights_;
  std::array<Features, 2> features_;
};

INSTANTIATE_TEST_SUITE_P(Isas, LightGlueOracle, testing::ValuesIn(SupportedIsas()),
                         [](const auto& test) { return IsaName(test.param); });

// Limits: some five times the noise of fp32 against fp64 in the published code.
TEST_P(LightGlueOracle, EveryStageAgrees) {
  const LightGlueNetwork network(ReadLightGlueWeights(weights_), GetParam());
  const auto check = [&](int blocks, const std::string& name, double limit) {
    Workspace workspace(pool_);
    const LightGlueState state =
        network.Run(features_[0], features_[1], kEverything, blocks, workspace);
    for (int i = 0; i < 2; ++i) {
      EXPECT_LT(LargestError(TokensOf(state.images[i], 256), name + std::to_string(i)), limit)
          << name << i;
    }
  };
  check(0, "full_proj_", 1e-6);
  check(1, "full_self1_", 2e-5);
  check(2, "full_layer1_", 2e-5);
  check(6, "full_layer3_", 1e-4);
  check(18, "full_layer9_", 5e-3);
  for (int layer = 1; layer <= 8; ++layer) {
    Workspace workspace(pool_);
    const LightGlueState state =
        network.Run(features_[0], features_[1], kEverything, 2 * layer, workspace);
    for (int i = 0; i < 2; ++i) {
      const std::string suffix = std::to_string(layer) + "_" + std::to_string(i);
      const Tensor<float>& matchability = oracle_->Floats("full_matchability" + suffix);
      const Tensor<float>& confidence = oracle_->Floats("full_confidence" + suffix);
      for (int64_t row = 0; row < state.images[i].count; ++row) {
        const float* const logits = state.images[i].logits + row * kernels::kBlock;
        const auto sigmoid = [](float x) { return 1.0F / (1.0F + std::exp(-x)); };
        ASSERT_NEAR(sigmoid(logits[0]), matchability[row], 5e-4) << layer;
        ASSERT_NEAR(sigmoid(logits[1]), confidence[row], 5e-4) << layer;
      }
    }
  }
  Workspace workspace(pool_);
  LightGlueState state = network.Run(features_[0], features_[1], kEverything, 18, workspace);
  const TensorView<float> similarity = network.Similarity(state, workspace);
  EXPECT_LT(LargestError(similarity.Matrix().leftCols(state.images[1].count), "full_similarity"),
            5e-3);
  const LightGlue lightglue(weights_, GetParam());
  const TensorView<float> assignment =
      lightglue.LogAssignment(features_[0], features_[1], workspace);
  EXPECT_LT(LargestError(assignment.Matrix(), "full_log_assignment"), 1e-2);
}

TEST_P(LightGlueOracle, MatchesStopAndWidthAgree) {
  CheckMatches("full", kEverything);
  CheckMatches("default", {});
  CheckMatches("depth", {.width_confidence = 0.0F});
  CheckMatches("width", {.depth_confidence = 0.0F});
}

}  // namespace
}  // namespace gluevo::nn
