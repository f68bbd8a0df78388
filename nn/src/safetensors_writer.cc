#include <cmath>
#include <nlohmann/json.hpp>

#include "gluevo/nn/output_file.h"
#include "gluevo/nn/weights.h"
#include "safetensors_header.h"

namespace gluevo::nn {

void WriteSafetensors(const std::filesystem::path& path, const Weights& weights) {
  nlohmann::ordered_json header = nlohmann::ordered_json::object();
  if (!weights.metadata.empty()) {
    header[kSafetensorsMetadata] = nlohmann::ordered_json::object();
    for (const auto& [name, text] : weights.metadata) {
      header[kSafetensorsMetadata][name] = text;
    }
  }
  uint64_t offset = 0;
  for (const auto& [name, tensor] : weights.tensors) {
    if (name == kSafetensorsMetadata) {
      throw Error(path.string() + ": a tensor cannot be named " + Quoted(name));
    }
    for (int64_t i = 0; i < tensor.size(); ++i) {
      if (!std::isfinite(tensor[i])) {
        throw Error(path.string() + ": tensor " + Quoted(name) + " holds " +
                    (std::isnan(tensor[i]) ? "NaN" : "an infinite value") +
                    ", expected finite weights");
      }
    }
    const uint64_t size = static_cast<uint64_t>(tensor.size()) * sizeof(float);
    nlohmann::ordered_json& entry = header[name];
    entry["dtype"] = "F32";
    entry["shape"] = nlohmann::ordered_json::array();
    for (int axis = 0; axis < tensor.shape().rank(); ++axis) {
      entry["shape"].push_back(tensor.extent(axis));
    }
    entry["data_offsets"] = {offset, offset + size};
    offset += size;
  }
  std::string text;
  try {
    text = header.dump();
  } catch (const nlohmann::json::exception&) {
    throw Error(path.string() + ": a name or a metadata text is not valid UTF-8");
  }
  while (text.size() % 8 != 0) {  // The data then begins at a multiple of eight.
    text += ' ';
  }
  if (text.size() > kLongestSafetensorsHeader) {
    throw Error(path.string() + ": a header of " + std::to_string(text.size()) +
                " bytes, at most " + std::to_string(kLongestSafetensorsHeader) + " are allowed");
  }
  WriteWholeFile(path, [&](std::ostream& stream) {
    const uint64_t length = text.size();
    stream.write(reinterpret_cast<const char*>(&length), sizeof(length));
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    for (const auto& [name, tensor] : weights.tensors) {
      stream.write(reinterpret_cast<const char*>(tensor.data()),
                   static_cast<std::streamsize>(tensor.size() * sizeof(float)));
    }
  });
}

}  // namespace gluevo::nn
