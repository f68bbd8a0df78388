// Files written by PyTorch (weights_tools/crosscheck/make_container_files.py), and what becomes of
// them when they are broken.

#include <gtest/gtest.h>

#include <cmath>

#include "hostile.h"
#include "nn/zip_files.h"
#include "pickle.h"

namespace gluevo::weights_tools {
namespace {

using nn::Archive;
using nn::Entry;
using nn::Shape;
using nn::Values;

void ExpectTheTensors(const Container& container, const std::string& form) {
  const nn::Weights& weights = container.weights;
  EXPECT_EQ(container.form, form);
  EXPECT_EQ(weights.source, "file");
  EXPECT_EQ(weights.checksum.size(), 64U);
  ASSERT_EQ(weights.tensors.size(), 8U);
  EXPECT_EQ(Values(weights.Get("plain", Shape{3, 4})),
            (std::vector<float>{0, 0.5F, 1, 1.5F, 2, 2.5F, 3, 3.5F, 4, 4.5F, 5, 5.5F}));
  EXPECT_EQ(Values(weights.Get("transposed", Shape{4, 3})),
            (std::vector<float>{0, 2, 4, 0.5F, 2.5F, 4.5F, 1, 3, 5, 1.5F, 3.5F, 5.5F}));
  EXPECT_EQ(Values(weights.Get("part", Shape{2, 2})), (std::vector<float>{3, 3.5F, 5, 5.5F}));
  EXPECT_EQ(Values(weights.Get("half", Shape{3})),
            (std::vector<float>{1.5F, -2, std::ldexp(1.0F, -24)}));
  EXPECT_EQ(Values(weights.Get("brain", Shape{2})), (std::vector<float>{1.5F, -3}));
  EXPECT_EQ(Values(weights.Get("wide", Shape{1})), (std::vector<float>{0.1F}));
  EXPECT_EQ(Values(weights.Get("parameter", Shape{1, 1})), (std::vector<float>{7}));
  EXPECT_EQ(Values(weights.Get("scalar", Shape{})), (std::vector<float>{-3}));
}

TEST(TorchTest, ReadsTheZipForm) { ExpectTheTensors(Parse(TestFile("torch.pth")), "torch"); }

TEST(TorchTest, ReadsTheLegacyForm) {
  ExpectTheTensors(Parse(TestFile("torch_legacy.pth")), "torch-legacy");
}

TEST(TorchTest, ReadsLaterPickleProtocols) {
  ExpectTheTensors(Parse(TestFile("torch_protocol4.pth")), "torch");
}

TEST(TorchTest, FindsTheDictionaryInsideACheckpoint) {
  ExpectTheTensors(Parse(TestFile("torch_wrapped.pth")), "torch");
  ExpectTheTensors(Parse(TestFile("torch_legacy_wrapped.pth")), "torch-legacy");
}

TEST(TorchTest, RefusesWhatIsNoDictionaryOfTensors) {
  ExpectRefused(TestFile("torch_module.pth"), "file: byte ",
                "asks for \"torch.nn.modules.conv.Conv2d\"");
  ExpectRefused(TestFile("torch_script.pt"), "file: byte ", "is a TorchScript program");
  ExpectRefused(TestFile("torch_integers.pth"), "file: byte ",
                "tensor \"w\" is of \"torch LongStorage\"");
  ExpectRefused(TestFile("torch_no_tensors.pth"), "file: byte ",
                "holds no tensors, only the keys \"epoch\", \"note\"");
}

TEST(TorchTest, EveryTruncationIsRefused) {
  ExpectEveryTruncationRefused(TestFile("torch.pth"));
  ExpectEveryTruncationRefused(TestFile("torch_legacy.pth"));
}

TEST(TorchTest, ChangedBytesNeverCrash) {
  ExpectFlipsSurvived(TestFile("torch.pth"));
  ExpectFlipsSurvived(TestFile("torch_legacy.pth"));
  ExpectFlipsSurvived(TestFile("torch_protocol4.pth"));
}

// An archive as PyTorch would make it of this pickle, with CRCs that fit.
std::string ArchiveOf(const std::string& pickle, const std::string& storage = std::string(16, 0)) {
  return Archive{{Entry("archive/data.pkl", pickle), Entry("archive/byteorder", "little"),
                  Entry("archive/data/0", storage)}}
      .Bytes();
}

constexpr const char* kStart = "\x80\2}";

std::string Text(const std::string& text) {
  return "X" + nn::Le(static_cast<uint32_t>(text.size())) + text;
}

// The dictionary {"w": tensor}, the tensor being of a storage with these arguments after it.
std::string PickleOfTensor(const std::string& arguments, const std::string& type = "Float",
                           const std::string& size = "K\4") {
  return kStart + Text("w") + "ctorch._utils\n_rebuild_tensor_v2\n((" + Text("storage") +
         "ctorch\n" + type + "Storage\n" + Text("0") + Text("cpu") + size + "tQ" + arguments +
         "\x89}tRs.";
}

TEST(TorchTest, ReadsAHandMadeArchive) {
  const std::string storage = nn::Floats({1, 2, 3, 4});
  const nn::Weights weights = Parse(ArchiveOf(PickleOfTensor("K\1(K\2t(K\2t"), storage)).weights;
  EXPECT_EQ(Values(weights.Get("w", Shape{2})), (std::vector<float>{2, 4}));
}

TEST(TorchTest, RefusesTensorsBeyondTheirStorage) {
  const std::string beyond = "reaches beyond its storage of 4 elements";
  ExpectRefused(ArchiveOf(PickleOfTensor("K\3(K\2t(K\1t")), "file: byte ", beyond);
  ExpectRefused(ArchiveOf(PickleOfTensor("K\4(K\1t(K\1t")), "file: byte ", beyond);
  const std::string huge = std::string("\x8a\x8") + "\xff\xff\xff\xff\xff\xff\xff\x7f";
  ExpectRefused(ArchiveOf(PickleOfTensor("K\1(K\2t(" + huge + "t")), "file: byte ", beyond);
  ExpectRefused(ArchiveOf(PickleOfTensor(huge + "(K\2t(K\1t")), "file: byte ", beyond);
  // More elements than there are by a stride of none, and by extents that overflow.
  ExpectRefused(ArchiveOf(PickleOfTensor(std::string("K\0(K\5t(K\0t", 10))), "file: byte ",
                "has more elements than its storage");
  ExpectRefused(ArchiveOf(PickleOfTensor("K\1(" + huge + huge + "t(K\1K\1t")), "file: byte ",
                "overflow");
}

TEST(TorchTest, RefusesArgumentsThatMakeNoTensor) {
  ExpectRefused(ArchiveOf(PickleOfTensor("K\1(K\2t(K\1K\1t")), "file: byte ",
                "has 1 extents and 2 strides");
  ExpectRefused(ArchiveOf(PickleOfTensor("K\1(K\1K\1K\1K\1K\1t(t")), "file: byte ",
                "no tuple of at most 4 numbers");
  ExpectRefused(ArchiveOf(PickleOfTensor("N(K\1t(K\1t")), "file: byte ",
                "offset is no positive number");
  ExpectRefused(ArchiveOf(PickleOfTensor("J\xff\xff\xff\xff(K\1t(K\1t")), "file: byte ",
                "offset is no positive number");
  ExpectRefused(ArchiveOf(PickleOfTensor("K\1(Nt(K\1t")), "file: byte ", "no positive numbers");
  ExpectRefused(ArchiveOf(PickleOfTensor("K\1(K\1t(K\1t", "ComplexFloat")), "file: byte ",
                "asks for \"torch.ComplexFloatStorage\"");
}

TEST(TorchTest, RefusesStoragesOfAnotherSize) {
  const std::string good = PickleOfTensor("K\1(K\2t(K\1t");
  ExpectRefused(ArchiveOf(good, std::string(15, 0)), "file: byte ",
                "storage \"0\" has 15 bytes, expected 4 elements of 4");
  ExpectRefused(ArchiveOf(PickleOfTensor("K\1(K\2t(K\1t", "Double")), "file: byte ",
                "expected 4 elements of 8");
  Archive without{{Entry("archive/data.pkl", good)}};
  ExpectRefused(without.Bytes(), "file: byte ", "there is no storage \"0\" in the archive");
}

TEST(TorchTest, RefusesBigEndianFiles) {
  Archive big{{Entry("a/data.pkl", PickleOfTensor("K\1(K\2t(K\1t")), Entry("a/byteorder", "big")}};
  ExpectRefused(big.Bytes(), "file: byte ", "byte order is \"big\"");
  std::string legacy = TestFile("torch_legacy.pth");
  const std::size_t at = legacy.find("little_endian");
  ASSERT_NE(at, std::string::npos);
  legacy[legacy.find('\x88', at)] = '\x89';
  ExpectRefused(legacy, "file: byte 21: ", "the file is big-endian");
}

TEST(TorchTest, RefusesNanWithItsPlaceInTheFile) {
  const std::string bytes = ArchiveOf(PickleOfTensor("K\1(K\2t(K\1t"), nn::Floats({1, 2, NAN, 4}));
  const std::size_t at = bytes.find(nn::Floats({1, 2, NAN, 4})) + 8;
  ExpectRefused(bytes, "file: byte " + std::to_string(at) + ": ", "tensor \"w\" holds NaN");
}

TEST(TorchTest, RefusesManyTensorsOfOneStorage) {
  // 100 times the same megabyte, of a file of little more than one.
  constexpr uint32_t kCount = 1 << 18;
  const std::string count = "J" + nn::Le(kCount);
  std::string pickle = std::string(kStart) + "(";
  for (int i = 0; i < 100; ++i) {
    pickle += Text(std::to_string(i)) + "ctorch._utils\n_rebuild_tensor\n((" + Text("storage") +
              "ctorch\nFloatStorage\n" + Text("0") + Text("cpu") + count + "tQK" +
              std::string(1, '\0') + "(" + count + "t(K\1ttR";
  }
  ExpectRefused(ArchiveOf(pickle + "u.", std::string(kCount * 4, '\0')), "file: byte ",
                "the tensors are more than 4 times the file's size");
}

// {"model": a, "net": a, ...} with all names that may wrap a dictionary, a being the same of b, and
// so on; the innermost one is large.
std::string Labyrinth(char depth) {
  const std::string start = std::string("}q") + depth + "(";
  if (depth == 0) {
    std::string pickle = start;
    for (int i = 0; i < 50'000; ++i) {
      pickle += Text("k" + std::to_string(i)) + "N";
    }
    return pickle + "u";
  }
  const char inner = static_cast<char>(depth - 1);
  std::string pickle = start + Text("state_dict") + Labyrinth(inner);
  for (const char* key : {"model_state_dict", "model", "net", "network", "weights", "params",
                          "superpoint", "superglue", "matcher", "extractor"}) {
    pickle += Text(key) + "h" + inner;
  }
  return pickle + "u";
}

TEST(TorchTest, DictionariesThatHoldEachOtherAreSearchedOnce) {
  ExpectRefused(ArchiveOf("\x80\2" + Labyrinth(4) + "."), "file: byte ", "holds no tensors");
}

TEST(TorchTest, ChangedPicklesNeverCrash) {
  const std::string file = TestFile("torch.pth");
  const std::size_t begin = file.find("\x80\2ccollections");
  ASSERT_NE(begin, std::string::npos);
  const std::string pickle = file.substr(begin, file.find("PK\7\x8", begin) - begin);
  ASSERT_NO_THROW(ReadPickle(nn::Bytes(pickle.data(), pickle.size(), "file")));
  const int refused =
      SurviveFlips(pickle, 20000, [](const std::string& bytes) { Parse(ArchiveOf(bytes)); });
  EXPECT_GT(refused, 10000);
}

}  // namespace
}  // namespace gluevo::weights_tools
