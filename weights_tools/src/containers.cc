#include "containers.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/input_file.h"
#include "gluevo/nn/npy.h"
#include "gluevo/nn/zip.h"
#include "onnx.h"
#include "onnx_model.h"
#include "torch.h"

namespace gluevo::weights_tools {
namespace {

bool StartsWith(const nn::Bytes& file, std::string_view start) {
  return std::string_view(reinterpret_cast<const char*>(file.data()), file.size())
      .starts_with(start);
}

constexpr const char* kKnownForms =
    "expected .pth or .pt of PyTorch, .safetensors, .npz, .npy or .onnx";

// Files that users have instead of the one they meant.
void RefuseUsualMistakes(const nn::Bytes& file) {
  if (file.size() == 0) {
    file.Fail(0, std::string("the file is empty, ") + kKnownForms);
  }
  constexpr std::size_t kTarNameAt = 257;
  if (StartsWith(file, "version https://git-lfs")) {
    file.Fail(0, "the file is a pointer of Git LFS: fetch the file itself with git lfs pull");
  }
  if (StartsWith(file, "<!DOCTYPE") || StartsWith(file, "<html")) {
    file.Fail(0, "the file is a web page, expected weights: it was not downloaded as it should be");
  }
  if (file.size() > kTarNameAt + 5 &&
      StartsWith(file.Slice(kTarNameAt, file.size() - kTarNameAt, ""), "ustar")) {
    file.Fail(0,
              "the file is a tar archive: unpack it, or, where PyTorch wrote it before 0.1.10, "
              "save it again with a later version");
  }
  if (StartsWith(file, "\x1f\x8b")) {
    file.Fail(0, "the file is compressed by gzip: unpack it first");
  }
  if (StartsWith(file, "\x89HDF")) {
    file.Fail(0, std::string("the file is HDF5, ") + kKnownForms);
  }
}

nn::Weights ParseSafetensors(const nn::Bytes& file, const std::string& source) {
  // The eighth byte of its header's length is zero, and what it begins with a brace.
  constexpr std::size_t kHeaderAt = 8;
  const bool looks_so =
      file.size() > kHeaderAt && (file.data()[kHeaderAt] == '{' || file.data()[kHeaderAt - 1] == 0);
  if (!looks_so) {
    file.Fail(0, std::string("the file is of no known form, ") + kKnownForms);
  }
  return nn::ParseWeights(file.data(), file.size(), source);
}

// An archive that somebody packed weights into, or of another program.
void RefuseOtherArchives(const nn::Bytes& file, const std::vector<nn::ZipEntry>& entries) {
  if (entries.empty()) {
    file.Fail(0, "the zip archive is empty");
  }
  if (std::none_of(entries.begin(), entries.end(),
                   [](const nn::ZipEntry& entry) { return entry.name.ends_with(".npy"); })) {
    file.Fail(0, "the zip archive is neither PyTorch's nor an .npz: it holds " +
                     Quoted(entries.front().name) + "; if weights are packed into it, unpack them");
  }
}

Container ParseZip(const nn::Bytes& file) {
  Container container;
  const std::vector<nn::ZipEntry> entries = nn::ReadZipDirectory(file);
  if (IsTorchArchive(entries)) {
    container.form = "torch";
    ParseTorchArchive(file, entries, container.weights);
  } else {
    RefuseOtherArchives(file, entries);
    container.form = "npz";
  }
  return container;
}

Container Parse(const nn::Bytes& file, const std::string& source) {
  RefuseUsualMistakes(file);
  if (StartsWith(file, "PK")) {
    Container container = ParseZip(file);
    if (container.form == "npz") {
      container.weights = nn::ParseWeights(file.data(), file.size(), source);
    }
    return container;
  }
  Container container;
  if (nn::LooksLikeNpy(file)) {
    container.form = "npy";
    const std::string name = std::filesystem::path(source).stem().string();
    if (std::optional<nn::Tensor<float>> tensor = nn::ParseNpy(file, name)) {
      container.weights.tensors.emplace(name, *std::move(tensor));
    }
  } else if (LooksLikeTorchLegacy(file)) {
    container.form = "torch-legacy";
    ParseTorchLegacy(file, container.weights);
  } else if (LooksLikeOnnx(file)) {
    container.form = "onnx";
    ParseOnnx(file, container);
  } else {
    container.form = "safetensors";
    container.weights = ParseSafetensors(file, source);
  }
  return container;
}

}  // namespace

Container ParseContainer(const void* bytes, std::size_t size, const std::string& source) {
  Container container = Parse(nn::Bytes(bytes, size, source), source);
  container.weights.source = source;
  if (container.weights.checksum.empty()) {
    container.weights.checksum = nn::Sha256(bytes, size);
  }
  return container;
}

Container ReadContainer(const std::filesystem::path& path) {
  const nn::InputFile file = nn::ReadInputFile(path);
  return ParseContainer(file.data.get(), file.size, path.string());
}

}  // namespace gluevo::weights_tools
