// Broken files of every form through everything that a conversion does: a network comes out, or one
// Error of one line, and nothing else happens.

#include <gtest/gtest.h>

#include <filesystem>

#include "dialects.h"
#include "gluevo/weights_tools/architecture.h"
#include "hostile.h"

namespace gluevo::weights_tools {
namespace {

namespace fs = std::filesystem;

std::string Seed(const std::string& name) {
  const fs::path path = fs::path(GLUEVO_TEST_DATA_DIR) / ".." / "fuzz" / "corpus" / name;
  std::ifstream stream(path, std::ios::binary);
  EXPECT_TRUE(stream) << path;
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<CanonicalNetwork> ConvertBytes(const std::string& bytes) {
  std::vector<CanonicalNetwork> networks = ToCanonical(Parse(bytes), kPublishedHeads);
  for (const CanonicalNetwork& network : networks) {
    ReadArchitecture(network.weights);
  }
  return networks;
}

class HostileFiles : public testing::TestWithParam<const char*> {};

TEST_P(HostileFiles, EveryTruncationIsRefusedOrLosesNoTensor) {
  const std::string whole = Seed(GetParam());
  const std::vector<CanonicalNetwork> expected = ConvertBytes(whole);
  int refused = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    try {
      // What follows the graph of an ONNX model may lack.
      const std::vector<CanonicalNetwork> networks = ConvertBytes(whole.substr(0, size));
      ASSERT_EQ(networks.size(), expected.size()) << size;
      EXPECT_EQ(networks[0].weights.tensors.size(), expected[0].weights.tensors.size()) << size;
      EXPECT_TRUE(std::string(GetParam()).starts_with("onnx/")) << size;
    } catch (const Error& error) {
      ++refused;
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(refused, static_cast<int>(whole.size()) - 100);
}

TEST_P(HostileFiles, ChangedBytesNeverCrash) {
  constexpr int kRounds = 10000;
  const int refused = SurviveFlips(Seed(GetParam()), kRounds, ConvertBytes);
  EXPECT_GT(refused, kRounds / 10);
}

INSTANTIATE_TEST_SUITE_P(
    Forms, HostileFiles,
    testing::Values("container/magic_leap.safetensors", "container/rpautrat.safetensors",
                    "container/hugging_face.safetensors", "container/superglue_half.safetensors",
                    "container/superglue_legacy.pth", "onnx/magic_leap.onnx",
                    "onnx/batch_norm.onnx", "onnx/int8.onnx", "onnx/qlinear.onnx"),
    [](const auto& seed) {
      std::string name = seed.param;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return c == '/' || c == '.'; }, '_');
      return name;
    });

TEST(HostileArrays, EveryTruncationOfANpyIsRefusedAndChangedBytesNeverCrash) {
  for (const char* seed : {"npy/c.npy", "npy/f_3.npy"}) {
    ExpectEveryTruncationRefused(Seed(seed));
    ExpectFlipsSurvived(Seed(seed));
  }
}

TEST(Corpus, EverySeedIsReadOrRefused) {
  int files = 0;
  int read = 0;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(GLUEVO_TEST_DATA_DIR) / ".." /
                                                            "fuzz" / "corpus")) {
    if (!entry.is_regular_file()) {
      continue;
    }
    ++files;
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    try {
      Parse(bytes);
      ++read;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << entry.path();
    }
  }
  EXPECT_GE(files, 23);
  EXPECT_GE(read, 20);
}

}  // namespace
}  // namespace gluevo::weights_tools
