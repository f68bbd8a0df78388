// Where the number of attention heads comes from, which no tensor tells.

#include "heads.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "gluevo/weights_tools/convert.h"
#include "gluevo/weights_tools/inspect.h"
#include "hostile.h"
#include "temporary_folder.h"

namespace gluevo::weights_tools {
namespace {

namespace fs = std::filesystem;

/// A folder as Hugging Face's save_pretrained leaves it.
class HeadsTest : public testing::Test {
 protected:
  fs::path Model(const std::string& file = "both_hugging_face.safetensors") const {
    fs::path to = folder_.path() / file;
    std::ofstream(to, std::ios::binary) << TestFile(file);
    return to;
  }
  void Config(const std::string& text) const {
    std::ofstream(folder_.path() / "config.json", std::ios::binary) << text;
  }
  nn::Weights SuperGlue(std::optional<int64_t> heads = std::nullopt) const {
    return Convert({Model()}, {.heads = heads, .network = "superglue"}).at(0);
  }
  void ExpectConfigRefused(const std::string& text, const std::string& message) const {
    Config(text);
    EXPECT_EQ(MessageOf([&] { SuperGlue(); }),
              (folder_.path() / "config.json").string() + ": " + message);
  }

  TemporaryFolder folder_;
};

constexpr const char* kTwoHeads = R"({"architectures": ["SuperGlueForKeypointMatching"],
  "gnn_layers_types": ["self", "cross"], "hidden_size": 32, "model_type": "superglue",
  "num_attention_heads": 2})";

TEST_F(HeadsTest, AreFourAsPublishedWhereNothingTells) {
  const nn::Weights weights = SuperGlue();
  EXPECT_EQ(weights.metadata.at("heads"), "4");
  EXPECT_TRUE(weights.metadata.contains("heads_assumed"));
}

TEST_F(HeadsTest, AreAsAsked) {
  const nn::Weights weights = SuperGlue(2);
  EXPECT_EQ(weights.metadata.at("heads"), "2");
  EXPECT_FALSE(weights.metadata.contains("heads_assumed"));
}

TEST_F(HeadsTest, AreThoseOfTheConfigBesideAHuggingFaceModel) {
  const nn::Weights asked = SuperGlue(2);
  const nn::Weights assumed = SuperGlue();
  Config(kTwoHeads);
  const nn::Weights weights = SuperGlue();
  EXPECT_EQ(weights.metadata, asked.metadata);
  bool another = false;
  for (const auto& [name, tensor] : asked.tensors) {
    EXPECT_EQ(weights.Get(name, tensor.shape()).Matrix(), tensor.Matrix()) << name;
    another = another || assumed.Get(name).Matrix() != tensor.Matrix();
  }
  EXPECT_TRUE(another);
  EXPECT_EQ(SuperGlue(2).metadata, asked.metadata);
}

TEST_F(HeadsTest, AConfigWithoutThemMeansItsDefault) {
  Config(R"({"model_type": "superglue"})");
  const nn::Weights weights = SuperGlue();
  EXPECT_EQ(weights.metadata.at("heads"), "4");
  EXPECT_FALSE(weights.metadata.contains("heads_assumed"));
}

TEST_F(HeadsTest, AConfigMayBeWrittenByWindows) {
  std::string text = kTwoHeads;
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) {
    text.insert(at, "\r");
  }
  Config("\xef\xbb\xbf" + text + "\r\n");
  EXPECT_EQ(SuperGlue().metadata.at("heads"), "2");
}

TEST_F(HeadsTest, ConfigsOfOtherThingsDoNotCount) {
  for (const char* config : {R"({"model_type": "bert", "num_attention_heads": 2})",
                             R"({"num_attention_heads": 2})", "[2]"}) {
    Config(config);
    EXPECT_EQ(SuperGlue().metadata.at("heads"), "4") << config;
  }
  // Nor does one beside a file of published names.
  Config(kTwoHeads);
  EXPECT_EQ(Convert({Model("superglue_magic_leap.pth")}).at(0).metadata.at("heads"), "4");
  Config("no JSON");
  EXPECT_NO_THROW(Convert({Model("superglue_magic_leap.pth")}));
}

TEST_F(HeadsTest, ConfigsThatCannotBeUsedAreRefused) {
  ExpectConfigRefused("{\"model_type\": ",
                      "byte 15: is not valid JSON, expected the config of the SuperGlue beside it");
  ExpectConfigRefused(R"({"model_type": "superglue", "num_attention_heads": 0})",
                      "\"num_attention_heads\" is \"0\", expected a positive number");
  ExpectConfigRefused(R"({"model_type": "superglue", "num_attention_heads": [2]})",
                      "\"num_attention_heads\" is \"[2]\", expected a positive number");
  ExpectConfigRefused(R"({"model_type": "superglue", "hidden_size": 1e3})",
                      "\"hidden_size\" is \"1000.0\", expected a positive number");
  const std::string order =
      "\"gnn_layers_types\" is not a list of \"self\" and \"cross\" in turns, the one order of "
      "layers that is known";
  for (const char* types : {R"(["cross", "self"])", R"(["self", "self"])", R"({"a": 1})", "[[]]"}) {
    ExpectConfigRefused(
        R"({"model_type": "superglue", "gnn_layers_types": )" + std::string(types) + "}", order);
  }
  ExpectConfigRefused(std::string((1 << 20) + 1, ' '),
                      "is of 1048577 bytes, at most 1048576 are read");
  ExpectConfigRefused(std::string(1 << 20, '['),
                      "byte 1048576: is not valid JSON, expected the config of the SuperGlue "
                      "beside it");
}

TEST_F(HeadsTest, WhatSaysOtherwiseIsRefused) {
  const std::string file = (folder_.path() / "both_hugging_face.safetensors").string();
  ExpectConfigRefused(R"({"model_type": "superglue", "gnn_layers_types": ["self"]})",
                      "says 1 layers, " + file + " has 2");
  ExpectConfigRefused(R"({"model_type": "superglue", "hidden_size": 256})",
                      "says 256 channels, " + file + " has 32");
  Config(kTwoHeads);
  EXPECT_EQ(MessageOf([&] { SuperGlue(4); }), (folder_.path() / "config.json").string() +
                                                  ": says 2 attention heads, asked for are 4");
  const fs::path converted = folder_.path() / "converted.safetensors";
  nn::WriteSafetensors(converted, SuperGlue());
  EXPECT_EQ(Convert({converted}).at(0).metadata.at("heads"), "2");
  EXPECT_EQ(MessageOf([&] { Convert({converted}, {.heads = 4}); }),
            converted.string() + ": says 2 attention heads, asked for are 4");
}

TEST_F(HeadsTest, InspectTellsThem) {
  EXPECT_NE(InspectionText(Model()).find("2 layers of 32, 4 heads (assumed)"), std::string::npos);
  const fs::path converted = folder_.path() / "converted.safetensors";
  nn::WriteSafetensors(converted, SuperGlue());
  EXPECT_NE(InspectionText(converted).find("2 layers of 32, 4 heads (assumed)"), std::string::npos);
  Config(kTwoHeads);
  EXPECT_NE(InspectionText(Model()).find("2 layers of 32, 2 heads,"), std::string::npos);
  EXPECT_NE(InspectionJson(Model()).find("\"heads\": 2"), std::string::npos);
  Config(R"({"model_type": "superglue", "hidden_size": 256})");
  EXPECT_NE(InspectionText(Model()).find("unknown: "), std::string::npos);
}

}  // namespace
}  // namespace gluevo::weights_tools
