// Operators that compute on quantised numbers: the weights that they mean.

#include "onnx_quantized.h"

#include <gtest/gtest.h>

#include "hostile.h"
#include "nn/weight_files.h"
#include "onnx_files.h"

namespace gluevo::weights_tools {
namespace {

using nn::Floats;
using nn::Values;

constexpr uint64_t kFloat = 1;
constexpr uint64_t kUint8 = 2;
constexpr uint64_t kInt8 = 3;
constexpr uint64_t kInt32 = 6;

std::string Ints(const std::vector<int32_t>& values) {
  std::string bytes;
  for (const int32_t value : values) {
    bytes += nn::Le(static_cast<uint32_t>(value));
  }
  return bytes;
}

std::string Scalar(const std::string& name, float value) {
  return Tensor(name, {}, kFloat, Floats({value}));
}
std::string Zero(const std::string& name, char value, uint64_t type = kInt8) {
  return Tensor(name, {}, type, std::string(1, value));
}

std::vector<std::string> Scales() {
  return {Scalar("xs", 0.5F), Zero("xz", 3), Scalar("ys", 0.1F), Zero("yz", 5)};
}

nn::Weights WeightsOf(const std::vector<std::string>& nodes, std::vector<std::string> tensors) {
  for (const std::string& scale : Scales()) {
    tensors.push_back(scale);
  }
  return Parse(Model(nodes, tensors)).weights;
}

TEST(OnnxQuantizedTest, AConvolutionsWeightsAndBias) {
  // Two channels of their own scales, [2 x 2 x 1 x 1]; a bias counts in scale times 0.5.
  const std::vector<std::string> tensors = {
      Tensor("conv.weight_quantized", {2, 2, 1, 1}, kInt8, std::string("\x01\xff\x02\x7f", 4)),
      Tensor("ws", {2}, kFloat, Floats({0.25F, 2})), Tensor("wz", {2}, kInt8, std::string(2, 0)),
      Tensor("conv.bias_quantized", {2}, kInt32, Ints({8, -3}))};
  const nn::Weights weights = WeightsOf({Node("QLinearConv",
                                              {"x", "xs", "xz", "conv.weight_quantized", "ws", "wz",
                                               "ys", "yz", "conv.bias_quantized"},
                                              "y")},
                                        tensors);
  EXPECT_EQ(weights.tensors.size(), 2U);
  EXPECT_EQ(Values(weights.Get("conv.weight", nn::Shape{2, 2, 1, 1})),
            (std::vector<float>{0.25F, -0.25F, 4, 254}));
  EXPECT_EQ(Values(weights.Get("conv.bias")), (std::vector<float>{1, -3}));
}

TEST(OnnxQuantizedTest, OneScaleAZeroPointAndNoBias) {
  const nn::Weights weights = WeightsOf(
      {Node("QLinearConv", {"x", "xs", "xz", "conv.weight", "ws", "wz", "ys", "yz"}, "y")},
      {Tensor("conv.weight", {1, 2, 1, 1}, kUint8, std::string("\x80\x00", 2)), Scalar("ws", 0.5F),
       Zero("wz", 64, kUint8)});
  EXPECT_EQ(Values(weights.Get("conv.weight")), (std::vector<float>{32, -32}));
  EXPECT_EQ(Values(weights.Get("conv.bias")), (std::vector<float>{0}));
}

TEST(OnnxQuantizedTest, AProductOfMatricesAndItsBias) {
  // [in x out], a scale an output; the bias is added behind it.
  const std::vector<std::string> nodes = {
      Node("QLinearMatMul", {"x", "xs", "xz", "m.weight", "ws", "wz", "ys", "yz"}, "p"),
      Node("com.microsoft.QLinearAdd", {"p", "ys", "yz", "m.bias", "bs", "bz", "ys", "yz"}, "y")};
  const nn::Weights weights =
      WeightsOf(nodes, {Tensor("m.weight", {3, 2}, kInt8, "\x01\x02\x03\x04\x05\x06"),
                        Tensor("ws", {2}, kFloat, Floats({1, 10})),
                        Tensor("wz", {2}, kInt8, std::string(2, 0)),
                        Tensor("m.bias", {2}, kInt8, "\x07\x09"), Scalar("bs", 2), Zero("bz", 1)});
  EXPECT_EQ(Values(weights.Get("m.weight", nn::Shape{2, 3})),
            (std::vector<float>{1, 3, 5, 20, 40, 60}));
  EXPECT_EQ(Values(weights.Get("m.bias")), (std::vector<float>{12, 16}));
}

TEST(OnnxQuantizedTest, AGemm) {
  const std::string trans_b = Text(5, Text(1, "transB") + Number(3, 1));
  const nn::Weights weights = WeightsOf(
      {Node("com.microsoft.QGemm", {"x", "xs", "xz", "m.weight", "ws", "wz", "m.bias", "ys", "yz"},
            "y", trans_b)},
      {Tensor("m.weight", {2, 1}, kInt8, "\x01\x02"), Tensor("ws", {2}, kFloat, Floats({4, 8})),
       Tensor("wz", {2}, kInt8, std::string(2, 0)), Tensor("m.bias", {2}, kInt32, Ints({1, 2}))});
  EXPECT_EQ(Values(weights.Get("m.weight", nn::Shape{2, 1})), (std::vector<float>{4, 16}));
  EXPECT_EQ(Values(weights.Get("m.bias")), (std::vector<float>{2, 8}));
}

OnnxModel Unfolded(char zero, uint64_t type) {
  const std::string bytes =
      Model({Node("QLinearConv", {"x", "xs", "xz", "w", "ws", "wz", "ys", "zero"}, "y")},
            {Zero("zero", zero, type)});
  OnnxModel model = ReadOnnxModel(nn::Bytes(bytes.data(), bytes.size(), "file"));
  UnfoldQuantizedOperators(model);
  return model;
}

TEST(OnnxQuantizedTest, AnOutputWithoutNegativeNumbersIsARelu) {
  for (const auto& [zero, type] : {std::pair('\0', kUint8), std::pair('\x80', kInt8)}) {
    const OnnxModel model = Unfolded(zero, type);
    ASSERT_EQ(model.nodes.size(), 4U);
    EXPECT_EQ(model.nodes[2].op, "Conv");
    EXPECT_EQ(model.nodes[3].op, "Relu");
    EXPECT_EQ(model.nodes[3].inputs, model.nodes[2].outputs);
    EXPECT_EQ(model.nodes[3].outputs, std::vector<std::string>{"y"});
  }
  for (const auto& [zero, type] : {std::pair('\1', kUint8), std::pair('\0', kInt8)}) {
    const OnnxModel model = Unfolded(zero, type);
    ASSERT_EQ(model.nodes.size(), 3U);
    EXPECT_EQ(model.nodes[2].outputs, std::vector<std::string>{"y"});
  }
}

TEST(OnnxQuantizedTest, RefusesWhatIsNotWhole) {
  ExpectRefused(Model({Node("QLinearConv", {"x", "xs"}, "y")}, {}), "file: byte ",
                "a QLinearConv has 2 inputs, expected at least 6");
  ExpectRefused(
      Model({Node("QLinearConv", {"x", "xs", "xz", "w", "ws", "wz", "ys", "yz"}, "y")}, {}),
      "file: byte ", "has no constant weights");
  const std::vector<std::string> weight = {Tensor("w", {2, 1, 1, 1}, kInt8, "\x01\x02"),
                                           Tensor("ws", {3}, kFloat, Floats({1, 1, 1}))};
  ExpectRefused(
      Model({Node("QLinearConv", {"x", "xs", "xz", "w", "ws", "", "ys", "yz"}, "y")}, weight),
      "file: byte ", "the scales of \"w\", 3, do not fit its shape [2 x 1 x 1 x 1]");
}

}  // namespace
}  // namespace gluevo::weights_tools
