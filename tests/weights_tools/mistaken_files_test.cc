// Files that users take for weights of a SuperPoint or a SuperGlue: what they are is said.

#include <gtest/gtest.h>

#include "dialects.h"
#include "hostile.h"
#include "nn/zip_files.h"
#include "small_networks.h"

namespace gluevo::weights_tools {
namespace {

TEST(MistakenFilesTest, FilesWithoutAForm) {
  const std::string known = "expected .pth or .pt of PyTorch, .safetensors, .npz, .npy or .onnx";
  ExpectRefused("", "file: byte 0: the file is empty, ", known);
  ExpectRefused("hi\x01", "file: byte 0: the file is of no known form, ", known);
  ExpectRefused("This is a text.", "file: byte 0: the file is the text \"This is a text.\", ",
                known);
  ExpectRefused("\x89HDF\r\n\x1a\n", "file: byte 0: the file is HDF5, ", known);
}

TEST(MistakenFilesTest, DownloadsThatAreNotYetTheFile) {
  ExpectRefused("version https://git-lfs.github.com/spec/v1\n", "file: byte 0: ", "git lfs pull");
  ExpectRefused("<!DOCTYPE html><html>", "file: byte 0: ", "is a web page");
  ExpectRefused(std::string(257, 'a') + "ustar and more", "file: byte 0: ", "tar archive");
  ExpectRefused("\x1f\x8b\x8 and more", "file: byte 0: ", "gzip");
}

TEST(MistakenFilesTest, ArchivesOfOtherThings) {
  ExpectRefused(nn::Archive{}.Bytes(), "file: byte 0: the zip archive is empty", "");
  ExpectRefused(nn::Archive{{nn::Entry("superpoint.pth", "x"), nn::Entry("a.npz", "x")}}.Bytes(),
                "file: byte 0: the zip archive is neither PyTorch's nor an .npz: ",
                "it holds \"superpoint.pth\"; if weights are packed into it, unpack them");
}

std::string MessageWith(const std::string& name, nn::Weights weights = {}) {
  weights.source = "file";
  weights.tensors.emplace(name, nn::Tensor<float>(nn::Shape{1}));
  return MessageOf([&] { ToCanonical({.weights = weights}, 4); });
}

TEST(MistakenFilesTest, OtherMatchers) {
  const std::string expected =
      "expected a SuperPoint, a SuperGlue, an ALIKED or a LightGlue under its published names";
  EXPECT_EQ(MessageWith("transformer_layers.0.self_attention.q_proj.weight"),
            "file: is a LightGlue in Hugging Face's form (tensor "
            "\"transformer_layers.0.self_attention.q_proj.weight\"), " +
                expected);
  EXPECT_EQ(
      MessageWith("matcher.loftr_coarse.layers.0.q_proj.weight"),
      "file: is a LoFTR (tensor \"matcher.loftr_coarse.layers.0.q_proj.weight\"), " + expected);
  // Hugging Face's LightGlue brings its SuperPoint along.
  EXPECT_NE(MessageWith("transformer_layers.0.self_attention.q_proj.weight", SmallSuperPoint())
                .find("is a LightGlue"),
            std::string::npos);
  EXPECT_NE(MessageWith("fc.weight").find("is neither a SuperPoint nor a SuperGlue"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::weights_tools
