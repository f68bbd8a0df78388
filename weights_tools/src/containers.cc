#include "containers.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/foreign_file.h"
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

constexpr const char* kKnownForms = ".pth or .pt of PyTorch, .safetensors, .npz, .npy or .onnx";

void RefuseOtherFiles(const nn::Bytes& file) {
  if (file.size() == 0) {
    file.Fail(0, std::string("the file is empty, expected ") + kKnownForms);
  }
  if (const std::optional<std::string> form = nn::ForeignForm(file, kKnownForms)) {
    file.Fail(0, "the file is " + *form);
  }
}

nn::Weights ParseSafetensors(const nn::Bytes& file, const std::string& source) {
  // The eighth byte of its header's length is zero, and what it begins with a brace.
  constexpr std::size_t kHeaderAt = 8;
  const bool looks_so =
      file.size() > kHeaderAt && (file.data()[kHeaderAt] == '{' || file.data()[kHeaderAt - 1] == 0);
  if (!looks_so) {
    file.Fail(0, std::string("the file is of no known form, expected ") + kKnownForms);
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
  RefuseOtherFiles(file);
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
