#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "gluevo/nn/elements.h"
#include "weight_files.h"

namespace gluevo::nn {
namespace {

std::string File(const std::string& header, const std::string& data) {
  return Le(uint64_t{header.size()}) + header + data;
}

// The header begins at byte 8, so the name of the first tensor of {"w":...} is at byte 9.
std::string One(const std::string& fields, const std::string& data) {
  return File("{\"w\":{" + fields + "}}", data);
}

std::string Entry(const std::string& name, int begin, int end) {
  return "\"" + name + R"(":{"dtype":"F32","shape":[)" + std::to_string((end - begin) / 4) +
         R"(],"data_offsets":[)" + std::to_string(begin) + "," + std::to_string(end) + "]}";
}

TEST(SafetensorsTest, ReadsTensorsOfEveryTypeAndMetadata) {
  // 1.5 is 0x3e00 as half and 0x3fc0 as bfloat16; -2 is 0xc000 as both.
  const std::string file = File(
      R"({"__metadata__":{"licence":"none \"at\" all"},)"
      R"("b":{"dtype":"F32","shape":[2,1],"data_offsets":[4,12]},)"
      R"("a":{"dtype":"F16","shape":[2],"data_offsets":[0,4]},)"
      R"("s":{"dtype":"BF16","shape":[],"data_offsets":[12,14]},)"
      R"("none":{"dtype":"F32","shape":[0,3],"data_offsets":[14,14]}}   )",
      Le<uint16_t>(0x3e00) + Le<uint16_t>(0xc000) + Floats({0.1F, -3.0F}) + Le<uint16_t>(0x3fc0));
  const Weights weights = Parse(file);
  EXPECT_EQ(weights.source, "file");
  EXPECT_EQ(weights.metadata.at("licence"), "none \"at\" all");
  ASSERT_EQ(weights.tensors.size(), 4U);
  EXPECT_EQ(Values(weights.Get("a", Shape{2})), (std::vector<float>{1.5F, -2.0F}));
  EXPECT_EQ(Values(weights.Get("b", Shape{2, 1})), (std::vector<float>{0.1F, -3.0F}));
  EXPECT_EQ(Values(weights.Get("s", Shape{})), (std::vector<float>{1.5F}));
  EXPECT_EQ(weights.Get("none").shape(), (Shape{0, 3}));
}

TEST(SafetensorsTest, HalfFollowsTheBitPatternsOfTheStandard) {
  // IEEE 754 binary16: 1 sign, 5 exponent (bias 15), 10 mantissa bits.
  EXPECT_EQ(HalfToFloat(0x0000), 0.0F);
  EXPECT_TRUE(std::signbit(HalfToFloat(0x8000)));
  EXPECT_EQ(HalfToFloat(0x3c00), 1.0F);
  EXPECT_EQ(HalfToFloat(0x3555), 0.333251953125F);
  EXPECT_EQ(HalfToFloat(0xc000), -2.0F);
  EXPECT_EQ(HalfToFloat(0x7bff), 65504.0F);
  EXPECT_EQ(HalfToFloat(0x0400), std::ldexp(1.0F, -14));     // Smallest normal.
  EXPECT_EQ(HalfToFloat(0x03ff), std::ldexp(1023.0F, -24));  // Largest subnormal.
  EXPECT_EQ(HalfToFloat(0x0001), std::ldexp(1.0F, -24));     // Smallest subnormal.
  EXPECT_EQ(HalfToFloat(0x8001), -std::ldexp(1.0F, -24));
  EXPECT_EQ(HalfToFloat(0x7c00), std::numeric_limits<float>::infinity());
  EXPECT_EQ(HalfToFloat(0xfc00), -std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(HalfToFloat(0x7e00)));
}

TEST(SafetensorsTest, HalfAgreesWithItsDefinitionForEveryFiniteValue) {
  for (int bits = 0; bits < 0x10000; ++bits) {
    const int exponent = (bits >> 10) & 31;
    if (exponent == 31) {
      continue;
    }
    const int mantissa = bits & 1023;
    const double magnitude =
        exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
    ASSERT_EQ(HalfToFloat(static_cast<uint16_t>(bits)), bits >= 0x8000 ? -magnitude : magnitude);
  }
}

TEST(SafetensorsTest, Bfloat16FollowsItsBitPatterns) {
  // The upper half of binary32: 1 sign, 8 exponent (bias 127), 7 mantissa bits.
  EXPECT_EQ(Bfloat16ToFloat(0x3f80), 1.0F);
  EXPECT_EQ(Bfloat16ToFloat(0x4049), 3.140625F);
  EXPECT_EQ(Bfloat16ToFloat(0xc000), -2.0F);
  EXPECT_EQ(Bfloat16ToFloat(0x0001), std::ldexp(1.0F, -133));   // Smallest subnormal.
  EXPECT_EQ(Bfloat16ToFloat(0x0080), std::ldexp(1.0F, -126));   // Smallest normal.
  EXPECT_EQ(Bfloat16ToFloat(0x7f7f), std::ldexp(255.0F, 120));  // Largest.
  EXPECT_EQ(Bfloat16ToFloat(0x7f80), std::numeric_limits<float>::infinity());
}

TEST(SafetensorsTest, RefusesNanAndInfinityAtTheirOffset) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string f32 = R"("dtype":"F32","shape":[3],"data_offsets":[0,12])";
  const uint64_t data = One(f32, "").size();
  ExpectRefused(One(f32, Floats({1, 2, nan})), data + 8, "tensor \"w\" holds NaN");
  ExpectRefused(One(f32, Floats({1, -INFINITY, 2})), data + 4, "holds an infinite value");
  const std::string f16 = R"("dtype":"F16","shape":[2],"data_offsets":[0,4])";
  ExpectRefused(One(f16, Le<uint16_t>(0x3c00) + Le<uint16_t>(0x7c00)), One(f16, "").size() + 2,
                "holds an infinite value");
  const std::string bf16 = R"("dtype":"BF16","shape":[2],"data_offsets":[0,4])";
  ExpectRefused(One(bf16, Le<uint16_t>(0xff80) + Le<uint16_t>(0)), One(bf16, "").size(),
                "holds an infinite value");
}

TEST(SafetensorsTest, NarrowsDouble) {
  const std::string f64 = R"("dtype":"F64","shape":[2],"data_offsets":[0,16])";
  const auto bits = [](double value) { return Le(std::bit_cast<uint64_t>(value)); };
  const Weights weights = Parse(One(f64, bits(0.1) + bits(-1e-50)));
  EXPECT_EQ(Values(weights.tensors.begin()->second), (std::vector<float>{0.1F, -0.0F}));
  ExpectRefused(One(f64, bits(1) + bits(1e39)), One(f64, "").size() + 8, "holds an infinite value");
}

TEST(SafetensorsTest, RefusesHeaderLengthsOutOfBounds) {
  ExpectRefused("", 0, "is empty");
  ExpectRefused("ab\x01", 0, "the header length is cut short");
  ExpectRefused(Le<uint64_t>(3) + "{}", 8, "the header is cut short: 3 bytes expected, 2 are");
  ExpectRefused(Le<uint64_t>(0), 8, "does not begin with {");
  ExpectRefused(Le<uint64_t>(100'000'001) + "{}", 0, "at most 100000000");
  ExpectRefused(Le(~uint64_t{0}) + "{}", 0, "at most 100000000");
  ExpectRefused(Le(~uint64_t{0} - 7) + "{}", 0, "at most 100000000");
}

TEST(SafetensorsTest, RefusesHeadersThatAreNotStrictJson) {
  ExpectRefused(File(" {}", ""), 8, "does not begin with {");
  ExpectRefused(File("[]", ""), 8, "does not begin with {");
  // The offset is that of the first byte that cannot be.
  ExpectRefused(File("{x}", ""), 9, "not valid JSON");
  ExpectRefused(File("{} x", ""), 11, "not valid JSON");
  ExpectRefused(File("{\"__metadata__\":{\"a\":\"b\",}}", ""), 33, "not valid JSON");
  ExpectRefused(File("{\"__metadata__\":{\"a\":NaN}}", ""), 29, "not valid JSON");
  ExpectRefused(File("{/**/}", ""), 9, "not valid JSON");
  ExpectRefused(File("{\"__metadata__\":{\"\xff\":\"b\"}}", ""), 26, "not valid JSON");
  ExpectRefused(File(std::string("{}\0{}", 5), ""), 10, "zero byte");
  ExpectRefused(File("{\"a\":" + std::string(100000, '[') + "}", ""), 9, "an array");
}

TEST(SafetensorsTest, RefusesNamesThatComeTwice) {
  const std::string first = Entry("w", 0, 4);
  ExpectRefused(File("{" + first + "," + Entry("w", 4, 8) + "}", Floats({1, 2})),
                9 + first.size() + 1, "the name \"w\" comes twice");
  // The same name, written with an escape.
  ExpectRefused(File("{" + first + "," + Entry("\\u0077", 4, 8) + "}", Floats({1, 2})),
                9 + first.size() + 1, "the name \"w\" comes twice");
  ExpectRefused(One(R"("dtype":"F32","dtype":"F32")", ""), 28, "\"dtype\" comes twice");
  ExpectRefused(File(R"({"__metadata__":{"a":"1","a":"2"}})", ""), 33, "\"a\" comes twice");
  ExpectRefused(File(R"({"__metadata__":{},"__metadata__":{}})", ""), 27,
                "\"__metadata__\" comes twice");
}

TEST(SafetensorsTest, NamesOffsetsOfKeysWithEscapes) {
  ExpectRefused(File(R"({"a\"\\":1})", ""), 9, "holds a number");
  ExpectRefused(File(R"({"__metadata__":{"":"", "\"":1}})", ""), 32, "holds a number");
}

TEST(SafetensorsTest, RefusesEntriesOfAnotherForm) {
  ExpectRefused(File(R"({"w":1})", ""), 9, "\"w\" holds a number");
  ExpectRefused(File(R"({"w":null})", ""), 9, "holds null");
  ExpectRefused(File(R"({"w":true})", ""), 9, "holds a boolean");
  ExpectRefused(File(R"({"w":"F32"})", ""), 9, "holds a string");
  ExpectRefused(File(R"({"__metadata__":"x"})", ""), 9, "holds a string");
  ExpectRefused(File(R"({"__metadata__":{"a":{}}})", ""), 25, "holds an object");
  ExpectRefused(One("", ""), 9, "has no \"dtype\"");
  ExpectRefused(One(R"("dtype":"F32","shape":[])", ""), 9, "has no \"data_offsets\"");
  ExpectRefused(One(R"("dtype":"F32","data_offsets":[0,0])", ""), 9, "has no \"shape\"");
  ExpectRefused(One(R"("colour":"F32")", ""), 14, "unknown field \"colour\"");
  ExpectRefused(One(R"("dtype":4)", ""), 14, "holds a number");
  ExpectRefused(One(R"("dtype":["F32"])", ""), 14, "holds an array");
  ExpectRefused(One(R"("shape":3)", ""), 14, "holds a number");
  ExpectRefused(One(R"("shape":[-3])", ""), 14, "holds a negative number");
  ExpectRefused(One(R"("shape":[3.0])", ""), 14, "no 64-bit integer");
  ExpectRefused(One(R"("shape":[18446744073709551616])", ""), 14, "no 64-bit integer");
  ExpectRefused(One(R"("shape":[[3]])", ""), 14, "holds an array");
  ExpectRefused(One(R"("shape":["3"])", ""), 14, "holds a string");
  ExpectRefused(One(R"("shape":[1,1,1,1,1])", ""), 14, "more than 4 numbers");
  ExpectRefused(One(R"("data_offsets":[0,0,0])", ""), 14, "more than 2 numbers");
}

TEST(SafetensorsTest, RefusesOffsetListsThatAreTooShort) {
  ExpectRefused(One(R"("dtype":"F32","shape":[1],"data_offsets":[0])", Floats({1})), 40,
                "\"data_offsets\" has 1 numbers, expected 2");
}

TEST(SafetensorsTest, RefusesOtherElementTypesByName) {
  for (const char* type : {"I8", "U8", "BOOL", "I64", "F8_E4M3", "f32", ""}) {
    ExpectRefused(One("\"dtype\":\"" + std::string(type) + R"(","shape":[1],"data_offsets":[0,8])",
                      std::string(8, '\0')),
                  9,
                  "has element type \"" + std::string(type) + "\", expected F32, F16, BF16 or F64");
  }
}

TEST(SafetensorsTest, RefusesSizesThatContradictOrOverflow) {
  const std::string data = Floats({1, 2});
  ExpectRefused(One(R"("dtype":"F32","shape":[3],"data_offsets":[0,8])", data), 9,
                "of shape [3] and type F32 has 8 bytes, expected 12");
  ExpectRefused(One(R"("dtype":"F16","shape":[2],"data_offsets":[0,8])", data), 9,
                "has 8 bytes, expected 4");
  ExpectRefused(One(R"("dtype":"F32","shape":[4611686018427387904,4],"data_offsets":[0,8])", data),
                9, "overflow");
  ExpectRefused(One(R"("dtype":"F32","shape":[4294967296,4294967296],"data_offsets":[0,0])", ""), 9,
                "overflow");
  ExpectRefused(One(R"("dtype":"F32","shape":[18446744073709551615],"data_offsets":[0,8])", data),
                9, "overflow");
}

TEST(SafetensorsTest, RefusesOffsetsOutOfBounds) {
  const std::string data = Floats({1, 2});
  for (const char* offsets : {"0,12", "8,0", "8,16", "18446744073709551612,0",
                              "18446744073709551612,18446744073709551615"}) {
    ExpectRefused(
        One(R"("dtype":"F32","shape":[2],"data_offsets":[)" + std::string(offsets) + "]", data), 9,
        "expected rising ones within 8 bytes");
  }
}

TEST(SafetensorsTest, RefusesOverlapsGapsAndTrailingBytes) {
  const std::string overlap = "{" + Entry("a", 0, 8) + "," + Entry("b", 4, 12) + "}";
  ExpectRefused(File(overlap, Floats({1, 2, 3})), 8 + overlap.size() + 4,
                "the data of tensor \"b\" overlaps");
  const std::string same = "{" + Entry("a", 0, 4) + "," + Entry("b", 0, 4) + "}";
  ExpectRefused(File(same, Floats({1})), 8 + same.size(), "overlaps");
  const std::string gap = "{" + Entry("a", 0, 4) + "," + Entry("b", 8, 12) + "}";
  ExpectRefused(File(gap, Floats({1, 2, 3})), 8 + gap.size() + 4, "4 bytes before the data of");
  const std::string late = "{" + Entry("a", 4, 8) + "}";
  ExpectRefused(File(late, Floats({1, 2})), 8 + late.size(), "4 bytes before the data of");
  const std::string whole = "{" + Entry("a", 0, 4) + "}";
  ExpectRefused(File(whole, Floats({1}) + "x"), 8 + whole.size() + 4, "1 trailing bytes");
}

TEST(SafetensorsTest, HostileNamesStayOnOneLine) {
  ExpectRefused(File("{\"a\\n\\u001b[31m\":1}", ""), 9, "\"a\\x0a\\x1b[31m\"");
  ExpectRefused(File("{\"" + std::string(5000, 'n') + "\":1}", ""), 9, "nnn...\"");
}

TEST(SafetensorsTest, LeavesTrainingCountersOut) {
  const std::string header =
      R"({"bn.num_batches_tracked":{"dtype":"I64","shape":[],"data_offsets":[0,8]},)" +
      Entry("w", 8, 12) + "}";
  const Weights weights = Parse(File(header, Le<uint64_t>(7) + Floats({1})));
  EXPECT_EQ(weights.tensors.size(), 1U);
  EXPECT_TRUE(weights.Has("w"));
}

std::string SmallFile() {
  const std::string header = R"({"__metadata__":{"a":"b"},)" + Entry("v", 0, 8) + "," +
                             R"("h":{"dtype":"F16","shape":[1,2],"data_offsets":[8,12]}})";
  return File(header, Floats({1, -2}) + Le<uint16_t>(0x3c00) + Le<uint16_t>(0x0001));
}

TEST(SafetensorsTest, EveryTruncationIsRefused) { ExpectEveryTruncationRefused(SmallFile()); }

TEST(SafetensorsTest, ChangedBytesNeverCrash) { ExpectFlipsSurvived(SmallFile(), 10000); }

}  // namespace
}  // namespace gluevo::nn
