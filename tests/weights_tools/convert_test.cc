#include "gluevo/weights_tools/convert.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "containers.h"
#include "hostile.h"
#include "nn/weight_files.h"
#include "small_networks.h"
#include "temporary_folder.h"

namespace gluevo::weights_tools {
namespace {

namespace fs = std::filesystem;

class ConvertTest : public testing::Test {
 protected:
  fs::path Save(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << bytes;
    return folder_.path() / name;
  }
  fs::path Save(const std::string& name, const nn::Weights& weights) const {
    nn::WriteSafetensors(folder_.path() / name, weights);
    return folder_.path() / name;
  }

 private:
  TemporaryFolder folder_;
};

// As numpy.save writes it, format 1.0.
std::string Npy(const nn::Tensor<float>& tensor) {
  std::string shape;
  for (int axis = 0; axis < tensor.shape().rank(); ++axis) {
    shape += std::to_string(tensor.extent(axis)) + ", ";
  }
  const std::string header =
      "{'descr': '<f4', 'fortran_order': False, 'shape': (" + shape + "), }\n";
  return "\x93NUMPY\x01" + std::string(1, '\0') + nn::Le(static_cast<uint16_t>(header.size())) +
         header + nn::Floats(nn::Values(tensor));
}

TEST_F(ConvertTest, ASingleArrayIsNamedByItsFile) {
  const std::string bytes = Npy(SmallSuperPoint().Get("conv1a.bias"));
  const Container container =
      ParseContainer(bytes.data(), bytes.size(), "/some/folder/conv1a.bias.npy");
  EXPECT_EQ(container.form, "npy");
  EXPECT_TRUE(container.weights.Has("conv1a.bias"));
}

TEST_F(ConvertTest, ANetworkMayBeSpreadOverFiles) {
  std::vector<fs::path> files;
  for (const auto& [name, tensor] : SmallSuperPoint().tensors) {
    files.push_back(Save(name + ".npy", Npy(tensor)));
  }
  const std::vector<nn::Weights> networks = Convert(files);
  ASSERT_EQ(networks.size(), 1U);
  for (const auto& [name, tensor] : SmallSuperPoint().tensors) {
    EXPECT_EQ(nn::Values(networks[0].Get(name, tensor.shape())), nn::Values(tensor)) << name;
  }
  files.push_back(files.front());
  EXPECT_NE(MessageOf([&] { Convert(files); }).find("is in an earlier input file too"),
            std::string::npos);
}

TEST_F(ConvertTest, TheOpenWeightsStayAsTheyAre) {
  const fs::path folder = fs::path(GLUEVO_TEST_DATA_DIR) / ".." / ".." / "nn" / "open_weights";
  for (const char* name : {"superpoint.safetensors", "superglue.safetensors"}) {
    const nn::Weights before = nn::ReadWeights(folder / name);
    const nn::Weights after = Convert({folder / name}).at(0);
    EXPECT_EQ(after.metadata, before.metadata);
    EXPECT_EQ(after.tensors.size(), before.tensors.size());
  }
}

TEST_F(ConvertTest, MetadataTellWhereWeightsComeFromAndWhatTheyFit) {
  const nn::Weights weights = Convert({Save("in.safetensors", SmallSuperPoint())}).at(0);
  EXPECT_EQ(weights.metadata.at("dialect"), "magic-leap");
  EXPECT_EQ(weights.metadata.at("source_file"), "in.safetensors");
  EXPECT_EQ(weights.metadata.at("source_form"), "safetensors");
  EXPECT_EQ(weights.metadata.at("source_sha256").size(), 64U);
  EXPECT_EQ(weights.metadata.at("converter").rfind("gluevo-weights ", 0), 0U);
  EXPECT_NE(weights.metadata.at("licence").find("not stated in the file"), std::string::npos);
  EXPECT_NE(weights.metadata.at("descriptors").find("fit a SuperGlue"), std::string::npos);
  EXPECT_FALSE(weights.metadata.contains("heads"));
  nn::Weights licensed = SmallSuperPoint();
  licensed.metadata["licence"] = "MIT";
  EXPECT_EQ(Convert({Save("b", licensed)}).at(0).metadata.at("licence"), "MIT");
}

TEST_F(ConvertTest, RefusesWhatOverflowsInTheConversion) {
  nn::Weights weights = SmallSuperPoint();
  std::mt19937 random(3);
  AddBatchNorm(weights, "bn2a", 4, random);
  weights.tensors.at("bn2a.weight")[1] = 3e38F;
  weights.tensors.at("conv2a.bias")[1] = 1e3F;
  const fs::path in = Save("in", weights);
  EXPECT_EQ(MessageOf([&] { Convert({in}); }),
            in.string() +
                ": tensor \"conv2a.bias\" of the converted network holds an infinite "
                "value or NaN, expected finite weights");
}

TEST_F(ConvertTest, RefusesOptionsOutOfRange) {
  const fs::path in = Save("in", SmallSuperGlue());
  EXPECT_EQ(MessageOf([&] { Convert({in}, {.heads = 0}); }),
            "number of heads 0 is out of range: expected at least 1");
  EXPECT_EQ(
      MessageOf([&] { Convert({in}, {.network = "superpose"}); }),
      "network \"superpose\" is unknown: expected \"superpoint\", \"superglue\", \"lightglue\" "
      "or \"aliked\"");
  EXPECT_EQ(MessageOf([&] { Convert({}); }), "no input file to convert");
  EXPECT_NE(MessageOf([&] { Convert({in}, {.heads = 3}); }).find("do not divide into 3 heads"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::weights_tools
