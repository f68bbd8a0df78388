// The command gluevo-weights, run as users run it.

#include "apps/command_test.h"

#include <nlohmann/json.hpp>

#include "small_networks.h"

namespace gluevo::weights_tools {
namespace {

using apps::Contents;
using apps::Outcome;
namespace fs = std::filesystem;
using Json = nlohmann::json;

class WeightsCommandTest : public apps::CommandTest {
 protected:
  std::string Save(const std::string& name, const nn::Weights& weights) const {
    nn::WriteSafetensors(Path(name), weights);
    return Path(name);
  }
  static std::string Data(const std::string& file) {
    return std::string(GLUEVO_TEST_DATA_DIR) + "/weights/" + file;
  }
  void ExpectRefused(const std::string& arguments, const std::string& phrase) const {
    const std::size_t files = Files();
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << outcome.error;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.error.rfind("gluevo-weights: ", 0), 0U) << outcome.error;
    EXPECT_NE(outcome.error.find(phrase), std::string::npos) << outcome.error;
    EXPECT_EQ(outcome.error.find('\n'), outcome.error.size() - 1) << outcome.error;
    EXPECT_EQ(Files(), files);
  }
};

TEST_F(WeightsCommandTest, ConvertsBothNetworks) {
  const std::string superpoint = Save("a.safetensors", SmallSuperPoint());
  const std::string superglue = Save("b.safetensors", SmallSuperGlue());
  const Outcome outcome = Run("convert " + superpoint + " -o " + Path("superpoint.safetensors"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(outcome.out, "");
  EXPECT_NE(outcome.error.find("superpoint, 24 tensors"), std::string::npos) << outcome.error;
  EXPECT_EQ(Run("convert " + superglue + " -o " + Path("superglue.safetensors")).exit_code, 0);

  const nn::Weights converted = nn::ReadWeights(Path("superpoint.safetensors"));
  for (const auto& [name, tensor] : SmallSuperPoint().tensors) {
    EXPECT_EQ(converted.Get(name, tensor.shape()).Matrix(), tensor.Matrix()) << name;
  }
  EXPECT_EQ(converted.metadata.at("architecture"), "superpoint");
  EXPECT_EQ(converted.metadata.at("source_sha256"), nn::ReadWeights(superpoint).checksum);
  EXPECT_EQ(nn::ReadWeights(Path("superglue.safetensors")).metadata.at("heads"), "4");
}

TEST_F(WeightsCommandTest, ConvertingTwiceGivesTheSameBytesAndItsOwnOutputTheSameAgain) {
  const std::string in = Save("in.safetensors", SmallSuperGlue());
  ASSERT_EQ(Run("convert " + in + " -o " + Path("a.safetensors")).exit_code, 0);
  ASSERT_EQ(Run("convert " + in + " -o " + Path("b.safetensors")).exit_code, 0);
  EXPECT_EQ(Contents(Path("a.safetensors")), Contents(Path("b.safetensors")));
  ASSERT_EQ(Run("convert " + Path("a.safetensors") + " -o " + Path("c.safetensors")).exit_code, 0);
  EXPECT_EQ(Contents(Path("a.safetensors")), Contents(Path("c.safetensors")));
}

TEST_F(WeightsCommandTest, TextsForTheMetadataAreKept) {
  const std::string in = Save("in.safetensors", SmallSuperPoint());
  ASSERT_EQ(Run("convert " + in + " -o " + Path("out.safetensors") +
                " --source 'a paper' --licence MIT --note 'of use'")
                .exit_code,
            0);
  const nn::Weights weights = nn::ReadWeights(Path("out.safetensors"));
  EXPECT_EQ(weights.metadata.at("source"), "a paper");
  EXPECT_EQ(weights.metadata.at("licence"), "MIT");
  EXPECT_EQ(weights.metadata.at("note"), "of use");
}

TEST_F(WeightsCommandTest, InspectPrintsATableAndJson) {
  const std::string in = Save("in.safetensors", SmallSuperGlue());
  const Outcome table = Run("inspect " + in);
  EXPECT_EQ(table.exit_code, 0) << table.error;
  EXPECT_NE(table.out.find("SuperGlue, 2 layers of 16, 4 heads (assumed), keypoint encoder 8"),
            std::string::npos)
      << table.out;
  EXPECT_NE(table.out.find("gnn.layers.1.mlp.0.weight"), std::string::npos);

  const Outcome outcome = Run("inspect " + in + " --json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json.at("architecture").at("network"), "superglue");
  EXPECT_EQ(json.at("sha256"), nn::ReadWeights(in).checksum);
  EXPECT_EQ(json.at("tensors").size(), SmallSuperGlue().tensors.size());
  EXPECT_EQ(json.at("tensors")[0].at("name"), "bin_score");
}

TEST_F(WeightsCommandTest, RefusesWhatIsNoNetworkAndWritesNothing) {
  const std::string out = " -o " + Path("out.safetensors");
  ExpectRefused("convert " + Path("none") + out, "there is no such file");
  ExpectRefused("convert " + Write("text", "This is no file of weights at all.") + out, "byte 0: ");
  nn::Weights lacking = SmallSuperPoint();
  lacking.tensors.erase("conv3a.bias");
  ExpectRefused("convert " + Save("lacking", lacking) + out, "there is no tensor \"conv3a.bias\"");
  nn::Weights odd = SmallSuperPoint();
  odd.tensors.at("conv2a.bias") = nn::Tensor<float>(nn::Shape{5});
  ExpectRefused("convert " + Save("odd", odd) + out, "has shape [5], expected [4]");
  ExpectRefused("inspect " + Path("none"), "there is no such file");
  const std::string in = Save("in.safetensors", SmallSuperPoint());
  ExpectRefused("convert " + in + " -o " + Path("no/such/folder.safetensors"), "cannot be written");
}

TEST_F(WeightsCommandTest, RefusesWhatIsCutShortAndWritesNothing) {
  const std::string whole = Contents(Data("superglue_magic_leap.pth"));
  ExpectRefused("convert " + Write("cut.pth", whole.substr(0, whole.size() - 1)) + " -o " +
                    Path("out.safetensors"),
                "is cut short");
}

TEST_F(WeightsCommandTest, ConvertsAFileOfBothIntoAFolderOrTheOneThatIsAsked) {
  const std::string both = Data("both_hugging_face.safetensors");
  ExpectRefused("convert " + both + " -o " + Path("out.safetensors"),
                "holds several networks: choose one by --network");
  ASSERT_EQ(Run("convert " + both + " --network superglue -o " + Path("glue")).exit_code, 0);
  ASSERT_EQ(Run("convert " + both + " -o " + Path("")).exit_code, 0);
  EXPECT_EQ(Contents(Path("glue")), Contents(Path("superglue.safetensors")));
  EXPECT_EQ(nn::ReadWeights(Path("superpoint.safetensors")).metadata.at("architecture"),
            "superpoint");
  EXPECT_EQ(Run("convert " + both + " --network other -o " + Path("x")).exit_code, 2);
  ExpectRefused(
      "convert " + Data("superpoint_magic_leap.pth") + " --network superglue -o " + Path("x"),
      "holds no superglue");
}

TEST_F(WeightsCommandTest, MakesTheFolderThatIsNamedOrWritesNothing) {
  const std::string both = Data("both_hugging_face.safetensors");
  ASSERT_EQ(Run("convert " + both + " -o " + Path("new/folder/")).exit_code, 0);
  EXPECT_TRUE(fs::exists(Path("new/folder/superpoint.safetensors")));
  EXPECT_TRUE(fs::exists(Path("new/folder/superglue.safetensors")));
  ExpectRefused("convert " + both + " -o " + Write("file", "") + "/", "cannot be made: ");
  // Both or none: here one cannot be written.
  fs::create_directories(Path("half/superpoint.safetensors"));
  ExpectRefused("convert " + both + " -o " + Path("half"), "cannot be written: is a folder");
  EXPECT_FALSE(fs::exists(Path("half/superglue.safetensors")));
  fs::create_directories(Path("other/superglue.safetensors"));
  ExpectRefused("convert " + both + " -o " + Path("other"), "cannot be written: is a folder");
  EXPECT_FALSE(fs::exists(Path("other/superpoint.safetensors")));
}

TEST_F(WeightsCommandTest, DoesNotWriteOverItsInput) {
  const std::string in = Save("superglue.safetensors", SmallSuperGlue());
  const std::string before = Contents(in);
  ExpectRefused("convert " + in + " -o " + in, "is an input itself");
  ExpectRefused("convert " + in + " -o " + Path("."), "is an input itself");
  const std::string point = Save("point", SmallSuperPoint());
  ExpectRefused("convert " + point + " " + in + " --network superglue -o " + Path(""),
                "is an input itself");
  EXPECT_EQ(Contents(in), before);
}

TEST_F(WeightsCommandTest, RefusesFolders) {
  ExpectRefused("convert " + Path("") + " -o " + Path("out"), "is a folder, expected a file");
  ExpectRefused("inspect " + Path(""), "is a folder, expected a file");
}

TEST_F(WeightsCommandTest, OwnOutputIsTheSameAgainForEveryDialect) {
  const auto convert = [this](const std::string& in, const std::string& out) {
    return Run("convert " + in + " -o " + out).exit_code;
  };
  for (const char* file :
       {"superpoint_rpautrat.pth", "superpoint_batch_norm.pth.tar",
        "superpoint_hugging_face.safetensors", "superglue_folded.onnx", "superpoint_int8.onnx"}) {
    const std::string a = Path(file) + ".a";
    const std::string b = Path(file) + ".b";
    ASSERT_EQ(convert(Data(file), a), 0) << file;
    ASSERT_EQ(convert(a, b), 0) << file;
    EXPECT_EQ(Contents(a), Contents(b)) << file;
  }
}

TEST_F(WeightsCommandTest, VerifyTellsTheSameNetworkFromAnother) {
  const std::string hugging_face = Data("both_hugging_face.safetensors") + " --network superglue";
  const Outcome same = Run("verify " + Data("superglue_magic_leap.pth") + " " + hugging_face);
  EXPECT_EQ(same.exit_code, 0) << same.error << same.out;
  EXPECT_NE(same.out.find("superglue   assignment   difference "), std::string::npos) << same.out;
  EXPECT_NE(same.out.find("superglue   matches      difference 0"), std::string::npos) << same.out;

  const std::string first = Save("first", SmallSuperPoint(1));
  const std::string second = Save("second", SmallSuperPoint(2));
  const Outcome other = Run("verify " + first + " " + second + " --json");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.error.find("is not the same network as"), std::string::npos) << other.error;
  const Json json = Json::parse(other.out);
  ASSERT_EQ(json.size(), 3U);
  EXPECT_EQ(json[1].at("output"), "descriptors");
  EXPECT_EQ(json[1].at("agrees"), false);
  EXPECT_GT(json[1].at("difference"), 0.1);
  EXPECT_EQ(Run("verify " + first + " " + first).exit_code, 0);

  const std::string glue = Save("glue", SmallSuperGlue());
  ExpectRefused("verify " + first + " " + glue, "holds no superpoint");
  ExpectRefused("verify " + glue + " " + first, "holds no superglue");

  ASSERT_EQ(Run("convert " + glue + " --heads 2 -o " + Path("two")).exit_code, 0);
  ExpectRefused("verify " + Path("two") + " " + glue,
                "glue: has 4 attention heads (assumed, see --heads), " + Path("two") +
                    " has 2 attention heads");
  EXPECT_EQ(Run("verify " + Path("two") + " " + glue + " --heads 2").exit_code, 0);
}

TEST_F(WeightsCommandTest, WhatSomebodyElseMadeIsNotReplaced) {
  const std::string in = Save("in.safetensors", SmallSuperPoint());
  for (const std::string& file :
       {Save("other.safetensors", SmallSuperGlue()), Write("notes", "notes")}) {
    const std::string before = Contents(file);
    ExpectRefused("convert " + in + " -o " + file,
                  file + ": cannot be written: a file is there that is not what gluevo-weights");
    EXPECT_EQ(Contents(file), before);
  }
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(Run("convert " + in + " -o " + Path("own.safetensors")).exit_code, 0);
  }
}

TEST_F(WeightsCommandTest, WhatCannotBePrintedIsAnError) {
  const std::string in = Save("in.safetensors", SmallSuperPoint());
  for (const std::string& arguments :
       {std::string("--help"), std::string("--version"), std::string("convert --help"),
        "inspect " + in, "verify " + in + " " + in}) {
    SCOPED_TRACE(arguments);
    const Outcome outcome =
        RunProgram("sh", "-c '" GLUEVO_PROGRAM " " + arguments + " >/dev/full'");
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(outcome.error,
              "gluevo-weights: error: standard output: cannot be written: No space left on "
              "device\n");
  }
}

TEST_F(WeightsCommandTest, BadUsageIsOneLine) {
  for (const auto& [arguments, text] :
       {std::pair{"convert x",
                  "--output is missing, expected: The .safetensors file to write, or a folder"},
        std::pair{"colour x", "\"colour\" is no command, expected one of convert, inspect"},
        std::pair{"inspect x y", "\"y\" is one argument too many, expected FILE"},
        std::pair{"convert x -o ''", "--output: expected a file or a folder"},
        std::pair{"get other", "NAME: expected aliked-n16, aliked-n16rot"},
        std::pair{"convert x -o y --heads 4.5", "--heads: expected a whole number, got"}}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_NE(outcome.error.find(text), std::string::npos) << outcome.error;
    EXPECT_EQ(outcome.error.find('\n'), outcome.error.size() - 1) << outcome.error;
  }
}

TEST_F(WeightsCommandTest, BadUsageIsExitCodeTwo) {
  for (const char* arguments :
       {"", "convert", "convert x", "inspect", "colour x", "inspect x y", "convert x -o ''"}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.error, "") << arguments;
  }
}

TEST_F(WeightsCommandTest, HelpShowsAnExample) {
  for (const char* arguments :
       {"--help", "convert --help", "inspect --help", "verify --help", "get --help"}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments;
    EXPECT_NE(outcome.out.find("Example:\n  gluevo-weights "), std::string::npos) << outcome.out;
  }
  EXPECT_EQ(Run("--version").out.rfind("gluevo-weights ", 0), 0U);
}

}  // namespace
}  // namespace gluevo::weights_tools
