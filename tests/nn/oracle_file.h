#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/nn/input_file.h"
#include "gluevo/nn/npy.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/zip.h"

// Outputs of the published networks in double precision, with their published weights as
// gluevo-weights has them: neither is part of the project, and tests skip where one of them is not
// there.
//   gluevo-weights get aliked-n16
//   GLUEVO_PUBLISHED_WEIGHTS=~/.local/share/gluevo/weights ctest --test-dir build/dev -R Oracle
namespace gluevo::nn {

/// The file NAME.npz of sample outputs, or nothing.
inline std::optional<std::filesystem::path> OraclePath(const std::string& name) {
  const std::filesystem::path path =
      std::filesystem::path(GLUEVO_SHARED_DIR) / "oracle_open" / (name + ".npz");
  return std::filesystem::exists(path) ? std::optional(path) : std::nullopt;
}

/// NAME.safetensors in the folder that the environment variable GLUEVO_PUBLISHED_WEIGHTS names.
inline std::optional<std::filesystem::path> PublishedWeightsPath(const std::string& name) {
  const char* const folder = std::getenv("GLUEVO_PUBLISHED_WEIGHTS");
  if (folder == nullptr) {
    return std::nullopt;
  }
  const std::filesystem::path path = std::filesystem::path(folder) / (name + ".safetensors");
  return std::filesystem::exists(path) ? std::optional(path) : std::nullopt;
}

/// An .npz file of floats and whole numbers.
class OracleFile {
 public:
  explicit OracleFile(const std::filesystem::path& path) : file_(ReadInputFile(path)) {
    const Bytes bytes(file_.data.get(), file_.size, path.string());
    for (const ZipEntry& entry : ReadZipDirectory(bytes)) {
      const std::string name = entry.name.substr(0, entry.name.size() - 4);  // Without ".npy".
      const ZipData data(entry);
      const auto* const start = reinterpret_cast<const char*>(data.bytes().data());
      uint16_t header_size = 0;
      std::memcpy(&header_size, start + 8, sizeof(header_size));
      const std::string header(start + 10, header_size);
      const char* const values = start + 10 + header_size;
      const std::size_t size = data.bytes().size() - 10 - header_size;
      if (header.find("<i8") != std::string::npos) {
        ReadIntegers<int64_t>(values, size, integers_[name]);
      } else if (header.find("<i4") != std::string::npos) {
        ReadIntegers<int32_t>(values, size, integers_[name]);
      } else {
        floats_.tensors[name] = ParseNpy(data.bytes(), name).value();
      }
    }
    floats_.source = path.string();
  }

  const Tensor<float>& Floats(const std::string& name) const { return floats_.Get(name); }
  /// Row-major.
  const std::vector<int64_t>& Integers(const std::string& name) const { return integers_.at(name); }

 private:
  template <typename T>
  static void ReadIntegers(const char* values, std::size_t size, std::vector<int64_t>& to) {
    std::vector<T> numbers(size / sizeof(T));
    std::memcpy(numbers.data(), values, numbers.size() * sizeof(T));
    to.assign(numbers.begin(), numbers.end());
  }

  InputFile file_;
  Weights floats_;
  std::map<std::string, std::vector<int64_t>> integers_;
};

}  // namespace gluevo::nn
