// ALIKED and LightGlue: conversion, what a file is called, and files that are no such network.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "containers.h"
#include "dialects.h"
#include "gluevo/nn/aliked.h"
#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/random_weights.h"
#include "gluevo/weights_tools/architecture.h"
#include "gluevo/weights_tools/convert.h"
#include "gluevo/weights_tools/inspect.h"
#include "gluevo/weights_tools/verify.h"
#include "hostile.h"
#include "nn/weight_files.h"
#include "temporary_folder.h"

namespace gluevo::weights_tools {
namespace {

namespace fs = std::filesystem;

nn::Weights SmallLightGlue() { return nn::RandomLightGlueWeights(2, 24, 32, 2); }
nn::Weights SmallAliked() { return nn::RandomAlikedWeights({4, 6, 8, 10}, 64, 3); }

class OpenNetworksTest : public testing::Test {
 protected:
  fs::path Save(const std::string& name, const nn::Weights& weights) const {
    nn::WriteSafetensors(folder_.path() / name, weights);
    return folder_.path() / name;
  }
  nn::Weights ConvertOne(const nn::Weights& weights) const {
    const std::vector<nn::Weights> networks = Convert({Save("in", weights)});
    EXPECT_EQ(networks.size(), 1U);
    return networks.at(0);
  }

 private:
  TemporaryFolder folder_;
};

void ExpectSameTensors(const nn::Weights& actual, const nn::Weights& expected) {
  ASSERT_EQ(actual.tensors.size(), expected.tensors.size());
  for (const auto& [name, tensor] : expected.tensors) {
    EXPECT_EQ(actual.Get(name, tensor.shape()).Matrix(), tensor.Matrix()) << name;
  }
}

nn::Weights WithPrefix(const nn::Weights& weights, const std::string& prefix) {
  nn::Weights wrapped;
  for (const auto& [name, tensor] : weights.tensors) {
    wrapped.tensors.emplace(prefix + name, tensor);
  }
  return wrapped;
}

TEST_F(OpenNetworksTest, PublishedNamesStayAsTheyAre) {
  const nn::Weights lightglue = ConvertOne(SmallLightGlue());
  ExpectSameTensors(lightglue, SmallLightGlue());
  EXPECT_EQ(lightglue.metadata.at("architecture"), "lightglue");
  EXPECT_EQ(lightglue.metadata.at("descriptor_size"), "24");
  EXPECT_EQ(lightglue.metadata.at("heads"), "2");
  EXPECT_FALSE(lightglue.metadata.contains("heads_assumed"));
  EXPECT_NE(lightglue.metadata.at("licence").find("Apache-2.0"), std::string::npos);
  EXPECT_EQ(nn::LightGlue(lightglue).layers(), 2);

  const nn::Weights aliked = ConvertOne(SmallAliked());
  ExpectSameTensors(aliked, SmallAliked());
  EXPECT_EQ(aliked.metadata.at("architecture"), "aliked");
  EXPECT_EQ(aliked.metadata.at("widths"), "4 6 8 10");
  EXPECT_EQ(aliked.metadata.at("samples"), "3");
  EXPECT_NE(aliked.metadata.at("licence").find("BSD-3-Clause"), std::string::npos);
  EXPECT_EQ(nn::Aliked(aliked).descriptor_size(), 64);
}

TEST_F(OpenNetworksTest, WhatStandsBeforeTheNamesIsTakenOff) {
  ExpectSameTensors(ConvertOne(WithPrefix(SmallLightGlue(), "matcher.")), SmallLightGlue());
  ExpectSameTensors(ConvertOne(WithPrefix(SmallAliked(), "module.")), SmallAliked());
}

// The names of LightGlue's first release, and its unused scalar.
TEST_F(OpenNetworksTest, FlatNamesAreNested) {
  nn::Weights flat;
  for (const auto& [name, tensor] : SmallLightGlue().tensors) {
    std::string old = name;
    for (const std::string block : {"self_attn", "cross_attn"}) {
      for (const std::string layer : {"0", "1"}) {
        const std::string nested = "transformers." + layer + "." + block + ".";
        if (name.starts_with(nested)) {
          old = block + "." + layer + "." + name.substr(nested.size());
        }
      }
    }
    flat.tensors.emplace(old, tensor);
  }
  flat.tensors.emplace("log_assignment.0.r", nn::Tensor<float>(nn::Shape{}));
  const nn::Weights converted = ConvertOne(flat);
  ExpectSameTensors(converted, SmallLightGlue());
  EXPECT_EQ(converted.metadata.at("dialect"), "lightglue-flat");
  flat.tensors.emplace("transformers.0.self_attn.Wqkv.weight",
                       nn::Tensor<float>(nn::Shape{96, 32}));
  EXPECT_NE(MessageOf([&] { ConvertOne(flat); }).find("is the second that means"),
            std::string::npos);
}

TEST_F(OpenNetworksTest, AFileMayHoldBoth) {
  nn::Weights both = WithPrefix(SmallAliked(), "extractor.");
  both.tensors.merge(WithPrefix(SmallLightGlue(), "matcher.").tensors);
  const fs::path file = Save("both", both);
  const std::vector<nn::Weights> networks = Convert({file});
  ASSERT_EQ(networks.size(), 2U);
  ExpectSameTensors(networks[0], SmallAliked());
  ExpectSameTensors(networks[1], SmallLightGlue());
  EXPECT_EQ(Convert({file}, {.network = "lightglue"}).at(0).metadata.at("architecture"),
            "lightglue");
}

TEST_F(OpenNetworksTest, InspectAndVerifyKnowThem) {
  const fs::path aliked = Save("aliked", SmallAliked());
  const fs::path lightglue = Save("lightglue", SmallLightGlue());
  EXPECT_NE(InspectionText(aliked).find("ALIKED, widths 4 6 8 10, descriptors of 64 from 3"),
            std::string::npos);
  EXPECT_NE(InspectionText(lightglue).find("LightGlue, 2 layers of 32, 2 heads"),
            std::string::npos);
  EXPECT_NE(InspectionJson(lightglue).find("\"adaptive_depth\": true"), std::string::npos);
  for (const fs::path& file : {aliked, lightglue}) {
    for (const OutputComparison& comparison : Verify(file, file)) {
      EXPECT_TRUE(comparison.agrees()) << comparison.output;
    }
  }
  nn::Weights other = SmallLightGlue();
  other.tensors.at("log_assignment.1.final_proj.weight")[0] += 1.0F;
  bool differs = false;
  for (const OutputComparison& comparison : Verify(lightglue, Save("other", other))) {
    differs = differs || !comparison.agrees();
  }
  EXPECT_TRUE(differs);
}

std::string Refusal(nn::Weights weights) {
  weights.source = "file";
  return MessageOf([&] {
    for (const CanonicalNetwork& network : ToCanonical({.weights = weights}, 4)) {
      ReadArchitecture(network.weights);
    }
  });
}

TEST_F(OpenNetworksTest, WhatDoesNotFitIsNamed) {
  // Every tensor is missed, and none may have another shape or be there besides.
  for (const nn::Weights& whole : {SmallLightGlue(), SmallAliked()}) {
    for (const auto& [name, tensor] : whole.tensors) {
      nn::Weights odd = whole;
      odd.tensors.at(name) = nn::Tensor<float>(nn::Shape{7, 1, 5});
      EXPECT_NE(Refusal(odd).find('"'), std::string::npos) << name;
      nn::Weights lacking = whole;
      lacking.tensors.erase(name);
      // Without a layer's confidence there is a LightGlue that cannot stop.
      if (!name.starts_with("token_confidence.")) {
        EXPECT_THROW(
            {
              lacking.source = "file";
              for (const CanonicalNetwork& network : ToCanonical({.weights = lacking}, 4)) {
                ReadArchitecture(network.weights);
              }
            },
            Error)
            << name;
      }
    }
    nn::Weights more = whole;
    more.tensors.emplace("colour", nn::Tensor<float>(nn::Shape{1}));
    EXPECT_NE(Refusal(more).find("\"colour\" does not belong to a"), std::string::npos);
  }
}

}  // namespace
}  // namespace gluevo::weights_tools
