// Names, wrappings and batch norms by hand: what becomes of them, and what is refused.

#include "dialects.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gluevo/weights_tools/architecture.h"
#include "hostile.h"
#include "nn/weight_files.h"
#include "plain_superpoint.h"
#include "small_networks.h"

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Tensor;
using nn::Values;
using nn::Weights;

Container Wrap(Weights weights) {
  weights.source = "file";
  return {std::move(weights), "safetensors", std::nullopt};
}

CanonicalNetwork One(Container container) {
  std::vector<CanonicalNetwork> networks = ToCanonical(std::move(container), kPublishedHeads);
  EXPECT_EQ(networks.size(), 1U);
  ReadArchitecture(networks.at(0).weights);
  return std::move(networks.at(0));
}

std::string RefusalOf(const Weights& weights) {
  return MessageOf([&] { One(Wrap(weights)); });
}

void ExpectSame(const Weights& actual, const Weights& expected) {
  EXPECT_EQ(actual.tensors.size(), expected.tensors.size());
  for (const auto& [name, tensor] : expected.tensors) {
    EXPECT_EQ(Values(actual.Get(name, tensor.shape())), Values(tensor)) << name;
  }
}

Weights Prefixed(const Weights& weights, const std::string& prefix) {
  Weights prefixed;
  for (const auto& [name, tensor] : weights.tensors) {
    prefixed.tensors.emplace(prefix + name, tensor);
  }
  return prefixed;
}

TEST(DialectsTest, PublishedNamesStayAsTheyAre) {
  const CanonicalNetwork superpoint = One(Wrap(SmallSuperPoint()));
  EXPECT_EQ(superpoint.dialect, "magic-leap");
  ExpectSame(superpoint.weights, SmallSuperPoint());
  ExpectSame(One(Wrap(SmallSuperGlue())).weights, SmallSuperGlue());
}

TEST(DialectsTest, WrappingsAreTakenOff) {
  for (const char* prefix : {"module.", "net.", "module.net.", "my_program.matcher.superpoint."}) {
    ExpectSame(One(Wrap(Prefixed(SmallSuperPoint(), prefix))).weights, SmallSuperPoint());
    ExpectSame(One(Wrap(Prefixed(SmallSuperGlue(), prefix))).weights, SmallSuperGlue());
  }
}

TEST(DialectsTest, AProgramsTwoNetworksComeApart) {
  Weights both = Prefixed(SmallSuperPoint(), "matching.superpoint.");
  both.tensors.merge(Prefixed(SmallSuperGlue(), "matching.superglue.").tensors);
  const std::vector<CanonicalNetwork> networks = ToCanonical(Wrap(both), kPublishedHeads);
  ASSERT_EQ(networks.size(), 2U);
  ExpectSame(networks[0].weights, SmallSuperPoint());
  ExpectSame(networks[1].weights, SmallSuperGlue());
}

TEST(DialectsTest, TwoOfAKindAreRefused) {
  Weights twice = Prefixed(SmallSuperPoint(1), "student.");
  twice.tensors.merge(Prefixed(SmallSuperPoint(2), "teacher.").tensors);
  EXPECT_NE(RefusalOf(twice).find("is the second that means \"conv1a.bias\""), std::string::npos)
      << RefusalOf(twice);
}

TEST(DialectsTest, ManyNetworksAreRefused) {
  Weights many;
  for (int i = 0; i < 20; ++i) {
    many.tensors.emplace("net" + std::to_string(i) + ".conv1a.weight", Tensor<float>(Shape{1}));
  }
  EXPECT_EQ(RefusalOf(many).find("file: holds more than 16 networks"), 0U) << RefusalOf(many);
}

TEST(DialectsTest, MatricesStandFor1x1Convolutions) {
  Weights superglue = SmallSuperGlue();
  for (auto& [name, tensor] : superglue.tensors) {
    if (tensor.shape().rank() == 3) {
      Tensor<float> matrix(Shape{tensor.extent(0), tensor.extent(1)});
      std::copy_n(tensor.data(), tensor.size(), matrix.data());
      tensor = matrix;
    }
  }
  Tensor<float> vector(Shape{1});
  vector[0] = superglue.Get("bin_score")[0];
  superglue.tensors.at("bin_score") = vector;
  ExpectSame(One(Wrap(superglue)).weights, SmallSuperGlue());
}

TEST(DialectsTest, ABatchNormBeforeTheReluBecomesPartOfItsConvolution) {
  Weights weights = SmallSuperPoint();
  std::mt19937 random(3);
  AddBatchNorm(weights, "bn2a", 4, random);
  AddBatchNorm(weights, "bnDb", 16, random);
  const CanonicalNetwork network = One(Wrap(weights));
  EXPECT_EQ(network.weights.tensors.size(), 24U);
  // y = (x - mean) / sqrt(variance + 1e-5) * weight + bias, in channel 3.
  const float mean = weights.Get("bn2a.running_mean")[3];
  const float gain =
      weights.Get("bn2a.weight")[3] / std::sqrt(weights.Get("bn2a.running_var")[3] + 1e-5F);
  EXPECT_FLOAT_EQ(network.weights.Get("conv2a.bias")[3],
                  gain * (weights.Get("conv2a.bias")[3] - mean) + weights.Get("bn2a.bias")[3]);
  EXPECT_FLOAT_EQ(network.weights.Get("conv2a.weight")[4 * 9 * 3 + 7],
                  gain * weights.Get("conv2a.weight")[4 * 9 * 3 + 7]);
  EXPECT_EQ(Values(network.weights.Get("conv2b.weight")), Values(weights.Get("conv2b.weight")));
}

TEST(DialectsTest, AConvolutionWithABatchNormNeedsNoBias) {
  Weights weights = SmallSuperPoint();
  std::mt19937 random(3);
  AddBatchNorm(weights, "bn2a", 4, random);
  Weights zero = weights;
  zero.tensors.at("conv2a.bias") = Tensor<float>(Shape{4});
  weights.tensors.erase("conv2a.bias");
  ExpectSame(One(Wrap(weights)).weights, One(Wrap(zero)).weights);
  weights.tensors.erase("conv2b.bias");
  EXPECT_EQ(RefusalOf(weights), "file: there is no tensor \"conv2b.bias\"");
}

TEST(DialectsTest, AnExportWithoutBatchNormsGetsOnesThatChangeNothing) {
  Weights superglue = SmallSuperGlue();
  std::erase_if(superglue.tensors, [](const auto& entry) {
    const std::string& name = entry.first;
    return name.find("encoder.1.") != std::string::npos || name.find("mlp.1.") != std::string::npos;
  });
  const Weights weights = One(Wrap(superglue)).weights;
  EXPECT_EQ(weights.tensors.size(), SmallSuperGlue().tensors.size());
  for (int i = 0; i < 8; ++i) {
    const double gain = weights.Get("kenc.encoder.1.weight")[i] /
                        std::sqrt(weights.Get("kenc.encoder.1.running_var")[i] + 1e-5);
    EXPECT_NEAR(gain, 1, 0x1p-24);
  }
  // But not where some are there: one that lacks is an error.
  Weights lacking = SmallSuperGlue();
  lacking.tensors.erase("gnn.layers.1.mlp.1.running_mean");
  EXPECT_EQ(RefusalOf(lacking), "file: there is no tensor \"gnn.layers.1.mlp.1.running_mean\"");
}

TEST(DialectsTest, AnotherEpsilonMovesIntoTheWeights) {
  Container container = Wrap(SmallSuperGlue());
  container.batch_norm_epsilon = 1e-2;
  const Weights weights = One(std::move(container)).weights;
  const Weights before = SmallSuperGlue();
  const std::string name = "gnn.layers.0.mlp.1";
  for (int64_t i = 0; i < 32; ++i) {
    const double variance = before.Get(name + ".running_var")[i];
    EXPECT_NEAR(weights.Get(name + ".weight")[i] / std::sqrt(variance + 1e-5),
                before.Get(name + ".weight")[i] / std::sqrt(variance + 1e-2), 1e-6);
  }
}

TEST(DialectsTest, NamesWhatDoesNotBelong) {
  Weights odd = SmallSuperPoint();
  odd.tensors.emplace("conv9a.weight", Tensor<float>(Shape{1}));
  EXPECT_EQ(RefusalOf(odd), "file: tensor \"conv9a.weight\" does not belong to a SuperPoint");
  Weights glue = SmallSuperGlue();
  glue.tensors.emplace("colour", Tensor<float>(Shape{1}));
  EXPECT_EQ(RefusalOf(glue), "file: tensor \"colour\" does not belong to a SuperGlue of 2 layers");
  Weights nothing;
  nothing.tensors.emplace("weight", Tensor<float>(Shape{1}));
  EXPECT_NE(RefusalOf(nothing).find("is neither a SuperPoint nor a SuperGlue"), std::string::npos);
  EXPECT_NE(RefusalOf(Weights{}).find("is neither a SuperPoint nor a SuperGlue"),
            std::string::npos);
}

TEST(DialectsTest, NamesTheTensorThatDoesNotFit) {
  Weights negative = SmallSuperGlue();
  negative.tensors.at("kenc.encoder.1.running_var")[2] = -1;
  EXPECT_NE(RefusalOf(negative).find("holds a negative variance at index 2"), std::string::npos);
  Weights scale = SmallSuperPoint();
  scale.tensors.emplace("conv1a.scale", Tensor<float>(Shape{4}));
  EXPECT_EQ(RefusalOf(scale), "file: there is no tensor \"conv1a.shift\"");
  Weights head = SmallSuperPoint();
  head.tensors.at("convPb.weight") = Tensor<float>(Shape{64, 10, 1, 1});
  EXPECT_NE(RefusalOf(head).find("\"convPb.bias\" has shape [65], expected [64]"),
            std::string::npos);
}

TEST(DialectsTest, HeadsMustDivideTheChannels) {
  EXPECT_NE(MessageOf([] {
              CanonicalNetwork network = One(Wrap(SmallSuperGlue()));
              network.weights.metadata["heads"] = "5";
              ReadArchitecture(network.weights);
            }).find("16 channels do not divide into 5 heads"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::weights_tools
