#include "gluevo/nn/weights.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "gluevo/nn/output_file.h"
#include "weight_files.h"

namespace gluevo::nn {
namespace {

namespace fs = std::filesystem;

class WeightsTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("gluevo_weights_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string ReadFile(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::size_t CountFiles() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

std::string MessageOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no Error";
  return "";
}

Tensor<float> Filled(const Shape& shape, float first) {
  Tensor<float> tensor(shape);
  for (int64_t i = 0; i < tensor.size(); ++i) {
    tensor[i] = first + static_cast<float>(i);
  }
  return tensor;
}

Weights Example() {
  Weights weights;
  weights.metadata = {{"note", "a \"quoted\"\nnote, \xc3\xa9"}, {"licence", "none"}};
  weights.tensors.emplace("b", Filled(Shape{2, 3}, 0.25F));
  weights.tensors.emplace("a", Filled(Shape{}, -1));
  weights.tensors.emplace("empty", Filled(Shape{0, 4}, 0));
  return weights;
}

TEST_F(WeightsTest, GetNamesFileAndTensor) {
  Weights weights = Example();
  weights.source = "file";
  EXPECT_EQ(MessageOf([&] { weights.Get("c"); }), "file: there is no tensor \"c\"");
  EXPECT_EQ(MessageOf([&] {
              weights.Get("b", Shape{3, 2});
            }),
            "file: tensor \"b\" has shape [2 x 3], expected [3 x 2]");
}

TEST_F(WeightsTest, ChecksumIsSha256) {
  // `printf '\002\0\0\0\0\0\0\0{}' | sha256sum`
  EXPECT_EQ(Parse(Le<uint64_t>(2) + "{}").checksum,
            "411a485216e432ece6b9af94fa32154cf79a2a56d4f81266baa50063f45092bd");
}

TEST_F(WeightsTest, WritesTheBytesOfTheFormat) {
  const fs::path path = folder_ / "w.safetensors";
  WriteSafetensors(path, Example());
  // By hand from the format's description: names in order, data without gaps, a header padded with
  // spaces so that the data begin at a multiple of eight.
  std::string header =
      "{\"__metadata__\":{\"licence\":\"none\",\"note\":\"a \\\"quoted\\\"\\nnote, \xc3\xa9\"},"
      R"("a":{"dtype":"F32","shape":[],"data_offsets":[0,4]},)"
      R"("b":{"dtype":"F32","shape":[2,3],"data_offsets":[4,28]},)"
      R"("empty":{"dtype":"F32","shape":[0,4],"data_offsets":[28,28]}})";
  header.resize((header.size() + 7) / 8 * 8, ' ');
  EXPECT_EQ(ReadFile(path), Le(uint64_t{header.size()}) + header +
                                Floats({-1, 0.25F, 1.25F, 2.25F, 3.25F, 4.25F, 5.25F}));
  EXPECT_EQ(CountFiles(), 1U);
}

TEST_F(WeightsTest, WhatIsWrittenIsReadBackTheSame) {
  const fs::path path = folder_ / "w.safetensors";
  WriteSafetensors(path, Example());
  const Weights weights = ReadWeights(path);
  EXPECT_EQ(weights.source, path.string());
  EXPECT_EQ(weights.metadata, Example().metadata);
  ASSERT_EQ(weights.tensors.size(), 3U);
  for (const auto& [name, tensor] : Example().tensors) {
    EXPECT_EQ(Values(weights.Get(name, tensor.shape())), Values(tensor)) << name;
  }
  const fs::path again = folder_ / "again.safetensors";
  WriteSafetensors(again, weights);
  EXPECT_EQ(ReadFile(again), ReadFile(path));
}

TEST_F(WeightsTest, TheFormIsToldByTheBytesNotTheName) {
  const fs::path path = folder_ / "w.npz";
  WriteSafetensors(path, Example());
  EXPECT_TRUE(ReadWeights(path).Has("b"));
}

TEST_F(WeightsTest, RefusesToWriteWhatCannotBeRead) {
  const fs::path path = folder_ / "w.safetensors";
  Weights nan = Example();
  nan.tensors.at("b")[4] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(MessageOf([&] { WriteSafetensors(path, nan); }),
            path.string() + ": tensor \"b\" holds NaN, expected finite weights");
  Weights reserved = Example();
  reserved.tensors.emplace("__metadata__", Filled(Shape{1}, 0));
  EXPECT_THROW(WriteSafetensors(path, reserved), Error);
  Weights text = Example();
  text.metadata["note"] = "\xff";
  EXPECT_EQ(MessageOf([&] { WriteSafetensors(path, text); }),
            path.string() + ": a name or a metadata text is not valid UTF-8");
  EXPECT_EQ(CountFiles(), 0U);
}

TEST_F(WeightsTest, AFileThatCannotBeWrittenLeavesNothing) {
  EXPECT_EQ(MessageOf([&] { WriteSafetensors(folder_ / "no" / "w.safetensors", Example()); }),
            (folder_ / "no" / "w.safetensors").string() +
                ": cannot be written: No such file or directory");
  fs::create_directory(folder_ / "taken");
  EXPECT_THROW(WriteSafetensors(folder_ / "taken", Example()), Error);
  EXPECT_EQ(CountFiles(), 1U);
}

TEST_F(WeightsTest, AWriterThatFailsLeavesTheOldFile) {
  const fs::path path = folder_ / "file";
  WriteWholeFile(path, [](std::ostream& stream) { stream << "old"; });
  EXPECT_THROW(WriteWholeFile(path,
                              [](std::ostream& stream) {
                                stream << "new";
                                throw Error("failed");
                              }),
               Error);
  EXPECT_EQ(ReadFile(path), "old");
  EXPECT_EQ(CountFiles(), 1U);
}

TEST_F(WeightsTest, AFileTakesThePlaceOfFilesOnly) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(MessageOf([&] { WriteSafetensors(pipe, Example()); }),
            pipe.string() + ": cannot be written: is a device or a pipe, expected a file");
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_EQ(MessageOf([&] { WriteSafetensors(folder_, Example()); }),
            folder_.string() + ": cannot be written: is a folder");
  EXPECT_EQ(CountFiles(), 1U);
}

TEST_F(WeightsTest, LinksStayAndWhatTheyPointToIsWritten) {
  const fs::path link = folder_ / "link";
  const fs::path file = folder_ / "file";
  std::ofstream(file) << "old";
  fs::create_symlink("file", link);
  WriteWholeFile(link, [](std::ostream& stream) { stream << "new"; });
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(ReadFile(file), "new");
  EXPECT_EQ(CountFiles(), 2U);
}

TEST_F(WeightsTest, RefusesWhatIsNoFile) {
  EXPECT_EQ(MessageOf([&] { ReadWeights(folder_ / "no"); }),
            (folder_ / "no").string() + ": there is no such file");
  EXPECT_EQ(MessageOf([&] { ReadWeights(folder_); }),
            folder_.string() + ": is a folder, expected a file");
  std::ofstream(folder_ / "empty").flush();
  EXPECT_EQ(
      MessageOf([&] { ReadWeights(folder_ / "empty"); }),
      (folder_ / "empty").string() + ": byte 0: the file is empty, expected .safetensors or .npz");
}

TEST_F(WeightsTest, SaysWhatAFileIsThatIsNoWeights) {
  const struct {
    std::string bytes;
    std::string said;
  } cases[] = {
      {"version https://git-lfs.github.com/spec/v1\noid sha256:1", "a pointer of Git LFS: fetch"},
      {"\n<!doctype HTML>\n<p>",
       "a web page, expected .safetensors or .npz: was it not downloaded"},
      {"\xef\xbb\xbf<html lang=\"en\">", "a web page"},
      {"<?xml version=\"1.0\"?><Error>", "XML"},
      {"{\"error\": \"Repository not found\"}\n", "the text \"{"},
      {"Entry not found", "the text \"Entry not found\", expected"},
      {"\x1f\x8b\x08 and more", "compressed by gzip: unpack it first"},
      {"\x89PNG\r\n\x1a\n and more", "an image, expected .safetensors or .npz"},
      {std::string(257, 'x') + "ustar", "a tar archive"},
  };
  for (const auto& [bytes, said] : cases) {
    const std::string message =
        MessageOf([&, &bytes = bytes] { ParseWeights(bytes.data(), bytes.size(), "page.pth"); });
    EXPECT_NE(message.find("page.pth: byte 0: the file is " + said), std::string::npos) << message;
  }
}

TEST_F(WeightsTest, RefusesFilesTooLargeToBeWeights) {
  std::ofstream(folder_ / "large").flush();
  std::error_code code;
  fs::resize_file(folder_ / "large", (uint64_t{4} << 30) + 1, code);
  if (code) {
    GTEST_SKIP() << "there is no place for a file with a hole: " << code.message();
  }
  EXPECT_EQ(MessageOf([&] { ReadWeights(folder_ / "large"); }),
            (folder_ / "large").string() + ": is of 4294967297 bytes, at most 4294967296 are read");
}

TEST_F(WeightsTest, QuotedTextIsPrintableAndShort) {
  EXPECT_EQ(Quoted("conv1a.weight"), "\"conv1a.weight\"");
  EXPECT_EQ(Quoted("a\n\"\\\xff"), "\"a\\x0a\\x22\\x5c\\xff\"");
  EXPECT_EQ(Quoted(std::string(101, 'x')), "\"" + std::string(100, 'x') + "...\"");
}

TEST_F(WeightsTest, OpenWeightsAreBuiltIn) {
  const Weights superpoint = OpenSuperPointWeights();
  EXPECT_EQ(superpoint.source, "built-in superpoint");
  EXPECT_EQ(superpoint.tensors.size(), 24U);
  superpoint.Get("conv1a.weight", Shape{32, 1, 3, 3});
  superpoint.Get("convDb.weight", Shape{256, 128, 1, 1});
  EXPECT_EQ(superpoint.metadata.at("licence"), "Apache-2.0");

  // Encoder 4 x 6 + 2, final projection 2, dustbin 1, and 16 a layer.
  const Weights superglue = OpenSuperGlueWeights();
  EXPECT_EQ(superglue.tensors.size(), 4U * 6 + 2 + 6 * 16 + 2 + 1);
  superglue.Get("bin_score", Shape{});
  superglue.Get("gnn.layers.5.mlp.0.weight", Shape{512, 512, 1});
  EXPECT_EQ(superglue.metadata.at("licence"), "Apache-2.0");
}

TEST_F(WeightsTest, OpenWeightsAreTheFilesOfTheRepository) {
  const fs::path folder = fs::path(GLUEVO_TEST_DATA_DIR) / ".." / ".." / "nn" / "open_weights";
  EXPECT_EQ(ReadWeights(folder / "superpoint.safetensors").checksum,
            OpenSuperPointWeights().checksum);
  EXPECT_EQ(ReadWeights(folder / "superglue.safetensors").checksum,
            OpenSuperGlueWeights().checksum);
}

TEST_F(WeightsTest, ReadsTheOpenFullSizeSuperPoint) {
  const fs::path path = fs::path(GLUEVO_SHARED_DIR) / "weights" / "superpoint_open.npz";
  if (!fs::exists(path)) {
    GTEST_SKIP() << "there is no " << path;
  }
  ReadWeights(path).Get("conv4b.weight", Shape{128, 128, 3, 3});
}

}  // namespace
}  // namespace gluevo::nn
