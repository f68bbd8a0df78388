// ONNX models put together field by field: what is read, and what is refused and why.

#include <gtest/gtest.h>

#include <cmath>

#include "hostile.h"
#include "nn/weight_files.h"
#include "onnx_constants.h"
#include "onnx_files.h"
#include "onnx_model.h"
#include "protobuf.h"

namespace gluevo::weights_tools {
namespace {

using nn::Floats;
using nn::Values;

std::vector<float> OnlyConstant(const std::vector<std::string>& nodes,
                                const std::vector<std::string>& tensors, const std::string& name) {
  const std::string bytes = Model(nodes, tensors);
  const OnnxModel model = ReadOnnxModel(nn::Bytes(bytes.data(), bytes.size(), "file"));
  const OnnxConstants constants(model, bytes.size());
  const std::optional<OnnxConstant> constant = constants.Get(name);
  return constant ? Values(constant->values) : std::vector<float>{};
}

TEST(OnnxTest, ReadsElementsOfEveryType) {
  const auto values = [](uint64_t type, const std::string& raw) {
    return OnlyConstant({}, {Tensor("w", {2}, type, raw)}, "w");
  };
  EXPECT_EQ(values(1, Floats({1, -2})), (std::vector<float>{1, -2}));
  EXPECT_EQ(values(10, nn::Le<uint16_t>(0x3e00) + nn::Le<uint16_t>(0xc000)),
            (std::vector<float>{1.5F, -2}));
  EXPECT_EQ(values(16, nn::Le<uint16_t>(0x3fc0) + nn::Le<uint16_t>(0xc000)),
            (std::vector<float>{1.5F, -2}));
  EXPECT_EQ(values(11, nn::Le(std::bit_cast<uint64_t>(0.1)) + nn::Le(std::bit_cast<uint64_t>(2.0))),
            (std::vector<float>{0.1F, 2}));
  EXPECT_EQ(values(3, "\xff\x7f"), (std::vector<float>{-1, 127}));
  EXPECT_EQ(values(2, "\xff\x7f"), (std::vector<float>{255, 127}));
  EXPECT_EQ(values(6, nn::Le(uint32_t{0xfffffffe}) + nn::Le(uint32_t{7})),
            (std::vector<float>{-2, 7}));
}

TEST(OnnxTest, ReadsValuesThatComeAsNumbers) {
  const std::string head = Number(1, 2);
  EXPECT_EQ(OnlyConstant({}, {head + Number(2, 1) + Text(8, "w") + Text(4, Floats({3, 4}))}, "w"),
            (std::vector<float>{3, 4}));
  EXPECT_EQ(
      OnlyConstant({},
                   {head + Number(2, 10) + Text(8, "w") + Text(5, Varint(0x3e00) + Varint(0xc000))},
                   "w"),
      (std::vector<float>{1.5F, -2}));
  EXPECT_EQ(
      OnlyConstant(
          {}, {head + Number(2, 3) + Text(8, "w") + Number(5, ~uint64_t{0}) + Number(5, 7)}, "w"),
      (std::vector<float>{-1, 7}));
}

TEST(OnnxTest, DequantizesByTensorAndByChannel) {
  // (q - zero) * scale: https://onnx.ai/onnx/operators/onnx__DequantizeLinear.html
  const std::string q = Tensor("q", {2, 2}, 3, std::string("\x01\x02\x03\x04", 4));
  EXPECT_EQ(OnlyConstant({Node("DequantizeLinear", {"q", "s", "z"}, "w")},
                         {q, Tensor("s", {}, 1, Floats({0.5F})), Tensor("z", {}, 3, "\x01")}, "w"),
            (std::vector<float>{0, 0.5F, 1, 1.5F}));
  const std::string scales = Tensor("s", {2}, 1, Floats({1, 10}));
  const std::string axis = Text(5, Text(1, "axis") + Number(3, 0));
  EXPECT_EQ(OnlyConstant({Node("DequantizeLinear", {"q", "s"}, "w", axis)}, {q, scales}, "w"),
            (std::vector<float>{1, 2, 30, 40}));
  EXPECT_EQ(OnlyConstant({Node("DequantizeLinear", {"q", "s"}, "w")}, {q, scales}, "w"),
            (std::vector<float>{1, 20, 3, 40}));
  const std::string three = Tensor("s", {3}, 1, Floats({1, 2, 3}));
  EXPECT_NE(MessageOf([&] {
              OnlyConstant({Node("DequantizeLinear", {"q", "s"}, "w")}, {q, three}, "w");
            }).find("the scales of \"q\", 3, do not fit its shape [2 x 2]"),
            std::string::npos);
}

TEST(OnnxTest, FollowsIdentitiesTransposesAndConstants) {
  const std::string w = Tensor("w", {1, 2}, 1, Floats({1, 2}));
  EXPECT_EQ(OnlyConstant({Node("Identity", {"w"}, "a"), Node("Transpose", {"a"}, "b")}, {w}, "b"),
            (std::vector<float>{1, 2}));
  const std::string value = Text(5, Text(1, "value") + Text(5, Tensor("", {1}, 1, Floats({5}))));
  EXPECT_EQ(OnlyConstant({Node("Constant", {}, "c", value)}, {}, "c"), (std::vector<float>{5}));
  EXPECT_EQ(OnlyConstant({Node("Relu", {"w"}, "a")}, {w}, "a"), (std::vector<float>{}));
  // A ring of nodes ends.
  EXPECT_EQ(OnlyConstant({Node("Identity", {"b"}, "a"), Node("Identity", {"a"}, "b")}, {}, "a"),
            (std::vector<float>{}));
}

TEST(OnnxTest, RefusesBrokenMessages) {
  const std::string start = "file: byte ";
  ExpectRefused(Number(1, 8) + Text(2, "maker"), start + "0: ", "the ONNX model has no graph");
  ExpectRefused(Number(1, 8) + Text(7, "") + Text(7, ""), start, "has two graphs");
  ExpectRefused(Number(1, 8) + "\x3a\x7fgraph", start + "4: ", "is cut short");
  ExpectRefused(Number(1, 8) + Varint(0) + "ab", start + "2: ", "has number 0");
  ExpectRefused(Number(1, 8) + "\x3b" + "ab", start + "2: ", "has type 3");
  ExpectRefused(Number(1, 8) + "\x10" + std::string(10, '\xff'), start, "more than 64 bits");
  ExpectRefused(Number(1, 8) + Number(7, 5), start, "is of another type than ONNX gives it");
  const std::string w = Tensor("w", {1}, 1, Floats({1}));
  ExpectRefused(Model({}, {w, w}), start, "tensor \"w\" comes twice");
  ExpectRefused(Model({Node("Relu", {"x"}, "y"), Node("Relu", {"x"}, "y")}, {}), start,
                "the value \"y\" of the ONNX model is made twice");
}

std::string Convolution(const std::string& attributes, const std::string& weight) {
  return Model({Node("Conv", {"x", "conv1a.weight"}, "y", attributes)}, {weight});
}

TEST(OnnxTest, RefusesTensorsThatCannotBeRead) {
  const auto weight = [](const std::vector<uint64_t>& dims, uint64_t type, const std::string& raw) {
    return Convolution("", Tensor("conv1a.weight", dims, type, raw));
  };
  const std::string start = "file: byte ";
  ExpectRefused(weight({1, 1, 1, 1}, 1, "abc"), start, "has 3 bytes, expected 4");
  ExpectRefused(weight({1, 1, 1, 1}, 3, "abc"), start, "has 3 values, expected 1");
  ExpectRefused(weight({1, 1, 1, 1}, 7, nn::Le(uint64_t{1})), start, "has element type 7 of ONNX");
  ExpectRefused(weight({1, 1, 1, 1}, 1, Floats({NAN})), start, "holds NaN");
  ExpectRefused(weight({1ULL << 40, 1ULL << 40, 1, 1}, 1, ""), start, "overflow");
  ExpectRefused(weight({1, 1, 1, 1, 1}, 1, Floats({1})), start, "rank 5");
  ExpectRefused(
      Convolution("", Tensor("conv1a.weight", {1, 1, 1, 1}, 1, Floats({1})) + Number(14, 1)), start,
      "is kept in another file");
}

TEST(OnnxTest, RefusesConvolutionsThatTheNetworksDoNotHave) {
  const std::string phrase = "has groups, strides, dilations or a padding";
  const std::string weight = Tensor("conv1a.weight", {1, 1, 3, 3}, 1, std::string(36, '\0'));
  const std::string pads = Integers("pads", {1, 1, 1, 1});
  for (const std::string& attributes :
       {std::string(), Integers("pads", {0, 0, 0, 0}), pads + Integers("strides", {2, 2}),
        pads + Integers("dilations", {2, 2}), pads + Text(5, Text(1, "group") + Number(3, 2))}) {
    ExpectRefused(Convolution(attributes, weight), "file: byte ", phrase);
  }
  // A good one is refused only for not being a whole network.
  EXPECT_EQ(Parse(Convolution(pads, weight)).weights.tensors.size(), 2U);
  ExpectRefused(Model({Node("Conv", {"x", "w"}, "y")}, {}), "file: byte ", "no constant weights");
  ExpectRefused(Model({Node("ConvInteger", {"x"}, "y")}, {}), "file: byte ",
                "the model has a ConvInteger, which is not read");
}

TEST(OnnxTest, ReadsEveryKindOfMatrix) {
  // [2 x 3], the outputs along the first axis; the transposed values are 1 3 5 2 4 6.
  const std::string w = Tensor("m.weight", {2, 3}, 1, Floats({1, 3, 5, 2, 4, 6}));
  const std::string transposed = Tensor("m.weight", {3, 2}, 1, Floats({1, 2, 3, 4, 5, 6}));
  const std::string bias = Tensor("m.bias", {2}, 1, Floats({7, 8}));
  const std::string trans_b = Text(5, Text(1, "transB") + Number(3, 1));
  for (const std::string& model :
       {Model({Node("Gemm", {"x", "m.weight", "m.bias"}, "y", trans_b)}, {w, bias}),
        Model({Node("Gemm", {"x", "m.weight", "m.bias"}, "y")}, {transposed, bias}),
        Model({Node("MatMul", {"x", "m.weight"}, "p"), Node("Add", {"m.bias", "p"}, "y")},
              {transposed, bias}),
        Model({Node("MatMul", {"m.weight", "x"}, "p"), Node("Add", {"p", "m.bias"}, "y")},
              {w, bias})}) {
    const nn::Weights weights = Parse(model).weights;
    EXPECT_EQ(Values(weights.Get("m.weight", nn::Shape{2, 3})),
              (std::vector<float>{1, 3, 5, 2, 4, 6}));
    EXPECT_EQ(Values(weights.Get("m.bias")), (std::vector<float>{7, 8}));
  }
}

TEST(OnnxTest, ABiasMayBeAddedBehindAnyLayer) {
  const std::string scale = Tensor("s", {}, 1, Floats({2}));
  const std::string bias = Tensor("c.bias", {1, 2, 1, 1}, 1, Floats({7, 8}));
  const std::string weight = Tensor("c.weight", {2, 1, 1, 1}, 1, Floats({1, 2}));
  for (const auto& between :
       {std::vector<std::string>{Node("Conv", {"x", "c.weight"}, "a")},
        std::vector<std::string>{Node("Conv", {"x", "c.weight"}, "p"),
                                 Node("QuantizeLinear", {"p", "s"}, "q"),
                                 Node("DequantizeLinear", {"q", "s"}, "a")}}) {
    std::vector<std::string> nodes = between;
    nodes.push_back(Node("Add", {"a", "c.bias"}, "y"));
    const nn::Weights weights = Parse(Model(nodes, {weight, bias, scale})).weights;
    EXPECT_EQ(Values(weights.Get("c.bias", nn::Shape{2})), (std::vector<float>{7, 8}));
  }
}

// Their order and their names alone would make the wrong network of them.
TEST(OnnxTest, RefusesConstantsBehindALayerThatWouldBeLost) {
  const std::string weight = Tensor("c.weight", {2, 1, 1, 1}, 1, Floats({1, 2}));
  const std::string bias = Tensor("c.bias", {2}, 1, Floats({7, 8}));
  const std::string more = Tensor("more", {1, 2, 1, 1}, 1, Floats({1, 2}));
  const std::string conv = Node("Conv", {"x", "c.weight", "c.bias"}, "a");
  for (const char* op : {"Add", "Sub", "Mul", "Div"}) {
    ExpectRefused(Model({conv, Node(op, {"a", "more"}, "y")}, {weight, bias, more}), "file: byte ",
                  std::string("the ") + op + " \"the node\" puts constants behind a layer");
  }
  // One factor is the scale of attention.
  const std::string one = Tensor("one", {}, 1, Floats({2}));
  EXPECT_NO_THROW(Parse(Model({conv, Node("Mul", {"a", "one"}, "y")}, {weight, bias, one})));
}

TEST(OnnxTest, RefusesModelsThatUseATensorTooOften) {
  // 2^20 values through 1000 identities.
  std::vector<std::string> nodes;
  for (int i = 0; i < 1000; ++i) {
    const std::string name = "i" + std::to_string(i);
    nodes.push_back(Node("Identity", {"w"}, name));
    nodes.push_back(Node("MatMul", {"x", name}, "y" + std::to_string(i)));
  }
  ExpectRefused(Model(nodes, {Tensor("w", {1024, 1024}, 1, std::string(4 << 20, '\0'))}),
                "file: byte ", "uses its tensors too often");
}

TEST(OnnxTest, RefusesMoreLayersThanTheNetworksHave) {
  std::vector<std::string> nodes;
  std::vector<std::string> tensors;
  for (int i = 0; i < 3000; ++i) {
    const std::string name = "m" + std::to_string(i);
    tensors.push_back(Tensor(name + ".weight", {1, 1}, 1, Floats({static_cast<float>(i)})));
    nodes.push_back(Node("MatMul", {"x", name + ".weight"}, name));
  }
  ExpectRefused(Model(nodes, tensors), "file: byte ", "has more than 2000 layers");
}

// Quantised by quantised numbers, over and over: 3^8 ways from the end to the beginning.
TEST(OnnxTest, LongChainsEnd) {
  std::vector<std::string> nodes;
  std::string last = "q";
  for (int i = 0; i < 2000; ++i) {
    const std::string next = "d" + std::to_string(i);
    nodes.push_back(Node("DequantizeLinear", {last, last, last}, next));
    nodes.push_back(Node("MatMul", {"x", next}, "y" + std::to_string(i)));
    last = next;
  }
  EXPECT_TRUE(Parse(Model(nodes, {})).weights.tensors.empty());
}

TEST(OnnxTest, SaysThatItKnowsNoOrderOfLayers) {
  const std::string weight = Tensor("a", {1, 1, 1, 1}, 1, Floats({1}));
  ExpectRefused(Model({Node("Conv", {"x", "a"}, "y")}, {weight}),
                "file: byte 0: ", "has 1 layers without names");
}

}  // namespace
}  // namespace gluevo::weights_tools
