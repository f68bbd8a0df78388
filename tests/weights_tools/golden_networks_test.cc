// Random networks that torch and transformers wrote and ran (weights_tools/crosscheck): converted,
// they give the same outputs.

#include <gtest/gtest.h>

#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "gluevo/weights_tools/convert.h"
#include "hostile.h"
#include "nn/golden.h"
#include "plain_superpoint.h"

namespace gluevo::weights_tools {
namespace {

using nn::kNetworkTolerance;
using nn::Weights;

std::string Path(const std::string& file) {
  return std::string(GLUEVO_TEST_DATA_DIR) + "/weights/" + file;
}

Weights ConvertOne(const std::string& file, const ConvertOptions& options = {}) {
  const std::vector<Weights> networks = Convert({Path(file)}, options);
  EXPECT_EQ(networks.size(), 1U);
  return networks.at(0);
}

struct SuperPointCase {
  std::string file;
  std::string golden;
  std::string dialect;
  int affine_layers = 0;
};

void PrintTo(const SuperPointCase& c, std::ostream* stream) { *stream << c.file; }

class GoldenSuperPoint : public testing::TestWithParam<SuperPointCase> {
 protected:
  // Outputs of either evaluation against torch's, and once more of the outermost rows and columns
  // alone, where a batch norm after the ReLU shows.
  void ExpectGolden(const Eigen::MatrixXd& scores, const Eigen::MatrixXd& descriptors) const {
    const auto expected = golden_.Get("scores").Matrix();
    const auto expected_descriptors = golden_.Get("descriptors").Matrix();
    EXPECT_LT(nn::RelativeRms(scores, expected), kNetworkTolerance);
    EXPECT_LT(nn::RelativeRms(descriptors, expected_descriptors), kNetworkTolerance);
    const auto last = expected.rows() - 1;
    const auto right = expected.cols() - 1;
    EXPECT_LT(nn::RelativeRms(scores.row(0), expected.row(0)), kNetworkTolerance);
    EXPECT_LT(nn::RelativeRms(scores.row(last), expected.row(last)), kNetworkTolerance);
    EXPECT_LT(nn::RelativeRms(scores.col(0), expected.col(0)), kNetworkTolerance);
    EXPECT_LT(nn::RelativeRms(scores.col(right), expected.col(right)), kNetworkTolerance);
  }

  Weights golden_ = nn::ReadGolden("weights/" + GetParam().golden);
};

TEST_P(GoldenSuperPoint, IsRecognised) {
  const Weights weights = ConvertOne(GetParam().file);
  EXPECT_EQ(weights.metadata.at("dialect"), GetParam().dialect);
  EXPECT_EQ(weights.metadata.contains("affine_layers"), GetParam().affine_layers > 0);
  if (GetParam().affine_layers > 0) {
    EXPECT_EQ(weights.metadata.at("affine_layers"), std::to_string(GetParam().affine_layers));
  }
}

TEST_P(GoldenSuperPoint, ConvertedTensorsMeanTheSameNetwork) {
  const PlainOutputs outputs = PlainSuperPoint(ConvertOne(GetParam().file), golden_.Get("image"));
  ExpectGolden(outputs.scores, outputs.descriptors);
}

TEST_P(GoldenSuperPoint, RunsTheSame) {
  const nn::Tensor<float>& image = golden_.Get("image");
  std::vector<uint8_t> pixels(image.data(), image.data() + image.size());
  const nn::GrayImage gray{pixels.data(), static_cast<int>(image.extent(1)),
                           static_cast<int>(image.extent(0)), image.extent(1)};
  nn::ThreadPool pool(1);
  nn::Workspace workspace(pool);
  const nn::SuperPoint superpoint(ConvertOne(GetParam().file));
  const nn::SuperPoint::DenseMaps maps = superpoint.Dense(gray, workspace);
  ExpectGolden(maps.scores.Matrix().cast<double>(), maps.descriptors.Matrix().cast<double>());
}

INSTANTIATE_TEST_SUITE_P(
    Dialects, GoldenSuperPoint,
    testing::Values(
        SuperPointCase{"superpoint_magic_leap.pth", "golden_superpoint_magic_leap", "magic-leap"},
        SuperPointCase{"superpoint_hugging_face.safetensors", "golden_superpoint_hugging_face",
                       "hugging-face"},
        SuperPointCase{"superpoint_batch_norm.pth.tar", "golden_superpoint_batch_norm",
                       "pytorch-superpoint"},
        SuperPointCase{"superpoint_folded.onnx", "golden_superpoint_batch_norm", "magic-leap"},
        SuperPointCase{"superpoint_folded_dynamo.onnx", "golden_superpoint_batch_norm",
                       "pytorch-superpoint"},
        SuperPointCase{"superpoint_int8.onnx", "golden_superpoint_int8", "magic-leap"},
        SuperPointCase{"superpoint_qlinear.onnx", "golden_superpoint_qlinear", "magic-leap"},
        SuperPointCase{"superpoint_rpautrat.onnx", "golden_superpoint_rpautrat", "rpautrat", 10},
        SuperPointCase{"superpoint_rpautrat.pth", "golden_superpoint_rpautrat", "rpautrat", 10}),
    [](const auto& c) {
      std::string name = c.param.file;
      std::replace(name.begin(), name.end(), '.', '_');
      return name;
    });

nn::Features GoldenFeatures(const Weights& golden, const std::string& image) {
  nn::Features features;
  features.width = static_cast<int>(golden.Get("size")[0]);
  features.height = static_cast<int>(golden.Get("size")[1]);
  features.keypoints = golden.Get("keypoints" + image).Matrix();
  features.scores = golden.Get("scores" + image).view().Vector();
  features.descriptors = golden.Get("descriptors" + image).Matrix();
  return features;
}

void ExpectGoldenSuperGlue(const Weights& weights) {
  const Weights golden = nn::ReadGolden("weights/golden_superglue");
  nn::ThreadPool pool(1);
  nn::Workspace workspace(pool);
  const nn::SuperGlue superglue(weights);
  const auto assignment = superglue.LogAssignment(GoldenFeatures(golden, "0"),
                                                  GoldenFeatures(golden, "1"), {}, workspace);
  EXPECT_LT(nn::RelativeRms(assignment.Matrix(), golden.Get("log_assignment").Matrix()),
            kNetworkTolerance);
}

TEST(GoldenSuperGlue, PublishedNamesInTheLegacyForm) {
  const Weights weights = ConvertOne("superglue_magic_leap.pth");
  EXPECT_EQ(weights.metadata.at("dialect"), "magic-leap");
  EXPECT_EQ(weights.metadata.at("source_form"), "torch-legacy");
  ExpectGoldenSuperGlue(weights);
}

TEST(GoldenSuperGlue, HuggingFacesNamesAndHeadOrder) {
  const Weights weights = ConvertOne("both_hugging_face.safetensors", {.network = "superglue"});
  EXPECT_EQ(weights.metadata.at("dialect"), "hugging-face");
  ExpectGoldenSuperGlue(weights);
  // The same network came in two dialects.
  const Weights published = ConvertOne("superglue_magic_leap.pth");
  ASSERT_EQ(weights.tensors.size(), published.tensors.size());
  for (const auto& [name, tensor] : published.tensors) {
    EXPECT_EQ(weights.Get(name, tensor.shape()).Matrix(), tensor.Matrix()) << name;
  }
}

TEST(GoldenSuperGlue, ExportsToOnnxWithNamesOrWithout) {
  for (const char* file :
       {"superglue_folded.onnx", "superglue_dynamo.onnx", "superglue_hugging_face.onnx"}) {
    SCOPED_TRACE(file);
    const Weights weights = ConvertOne(file);
    EXPECT_EQ(weights.metadata.at("source_form"), "onnx");
    ExpectGoldenSuperGlue(weights);
  }
}

// Hugging Face's layers are products of matrices whose channels are in another order than the
// published convolutions': without names nothing tells which.
TEST(GoldenSuperGlue, AnExportOfMatricesThatLostAllNamesIsRefused) {
  std::string bytes = TestFile("superglue_hugging_face.onnx");
  const std::string ending = ".bias";
  for (std::size_t at = 0; (at = bytes.find(ending, at)) != std::string::npos;) {
    bytes.replace(at, ending.size(), "_lost");
  }
  EXPECT_NO_THROW(Parse(TestFile("superglue_hugging_face.onnx")));
  ExpectRefused(bytes, "file: byte ", "nothing tells the order of the channels of its attention");
}

TEST(GoldenSuperGlue, AFileOfBothGivesBoth) {
  const std::vector<Weights> networks = Convert({Path("both_hugging_face.safetensors")});
  ASSERT_EQ(networks.size(), 2U);
  EXPECT_EQ(networks[0].metadata.at("architecture"), "superpoint");
  EXPECT_EQ(networks[1].metadata.at("architecture"), "superglue");
  EXPECT_EQ(networks[1].metadata.at("source_sha256"), networks[0].metadata.at("source_sha256"));
}

TEST(GoldenSuperGlue, HeadsAreThoseOfTheOptions) {
  const Weights four = ConvertOne("both_hugging_face.safetensors", {.network = "superglue"});
  const Weights two =
      ConvertOne("both_hugging_face.safetensors", {.heads = 2, .network = "superglue"});
  EXPECT_EQ(four.metadata.at("heads"), "4");
  EXPECT_EQ(two.metadata.at("heads"), "2");
  const std::string name = "gnn.layers.0.attn.proj.0.bias";
  // Channel 1 is dimension 0 of head 1: of four heads of 8 dimensions, or of two of 16.
  EXPECT_EQ(four.Get(name)[2], two.Get(name)[1]);
  EXPECT_NE(four.Get(name)[1], two.Get(name)[1]);
}

}  // namespace
}  // namespace gluevo::weights_tools
