#include "npz.h"

#include <string_view>
#include <utility>

#include "gluevo/nn/npy.h"
#include "gluevo/nn/zip.h"

namespace gluevo::nn {

void ParseNpz(const Bytes& file, Weights& weights) {
  for (const ZipEntry& entry : ReadZipDirectory(file)) {
    constexpr std::string_view kSuffix = ".npy";
    if (!std::string_view(entry.name).ends_with(kSuffix) || entry.name.size() == kSuffix.size()) {
      file.Fail(
          entry.at,
          "entry " + Quoted(entry.name) + " of the archive is no .npy array" +
              (entry.name.ends_with(".pkl") ? ": gluevo-weights converts PyTorch's files" : ""));
    }
    const std::string name = entry.name.substr(0, entry.name.size() - kSuffix.size());
    const ZipData data(entry);
    if (std::optional<Tensor<float>> tensor = ParseNpy(data.bytes(), name)) {
      weights.tensors.emplace(name, *std::move(tensor));
    }
  }
}

}  // namespace gluevo::nn
