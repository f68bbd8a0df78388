#include "gluevo/weights_tools/inspect.h"

#include <algorithm>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <variant>
#include <vector>

#include "containers.h"
#include "dialects.h"
#include "gluevo/weights_tools/architecture.h"
#include "heads.h"

namespace gluevo::weights_tools {
namespace {

using Json = nlohmann::ordered_json;

struct Network {
  Architecture architecture;
  std::string dialect;
};

struct Identity {
  std::vector<Network> networks;
  std::string problem;
};

Identity Identify(const std::filesystem::path& path, const Container& container) {
  try {
    const std::optional<SuperGlueConfig> config = ReadSuperGlueConfig(path, container.weights);
    const std::optional<int64_t> heads = FindHeads(container.weights, config, std::nullopt);
    Identity identity;
    for (CanonicalNetwork& network : ToCanonical(container, heads.value_or(kPublishedHeads))) {
      if (heads) {
        network.weights.metadata["heads"] = std::to_string(*heads);
      }
      const Architecture architecture = ReadArchitecture(network.weights);
      if (const auto* superglue = std::get_if<SuperGlueArchitecture>(&architecture);
          superglue != nullptr && config) {
        CheckConfig(*config, *superglue, network.weights.source);
      }
      identity.networks.push_back({architecture, network.dialect});
    }
    return identity;
  } catch (const Error& error) {
    return {{}, error.what()};
  }
}

int64_t CountParameters(const nn::Weights& weights) {
  int64_t count = 0;
  for (const auto& [name, tensor] : weights.tensors) {
    count += tensor.size();
  }
  return count;
}

// Texts of a file must not steer the terminal.
std::string Printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
  return text;
}

std::string Describe(const Architecture& architecture) {
  std::ostringstream text;
  const auto metadata = ArchitectureMetadata(architecture);
  if (const auto* superpoint = std::get_if<SuperPointArchitecture>(&architecture)) {
    text << "SuperPoint, widths " << metadata.at("widths") << ", detector head "
         << superpoint->detector_width << ", descriptor head " << superpoint->descriptor_width
         << ", descriptors of " << superpoint->descriptor_size;
    if (superpoint->affine_layers > 0) {
      text << ", scale and shift after " << superpoint->affine_layers << " layers";
    }
  } else if (const auto* superglue = std::get_if<SuperGlueArchitecture>(&architecture)) {
    text << "SuperGlue, " << superglue->layers << " layers of " << superglue->descriptor_size
         << ", " << superglue->heads << " heads" << (superglue->heads_assumed ? " (assumed)" : "")
         << ", keypoint encoder " << metadata.at("keypoint_encoder");
  } else if (const auto* lightglue = std::get_if<LightGlueArchitecture>(&architecture)) {
    text << "LightGlue, " << lightglue->layers << " layers of " << lightglue->size << ", "
         << lightglue->heads << " heads, for descriptors of " << lightglue->descriptor_size
         << (lightglue->adaptive_depth ? "" : ", cannot tell when to stop");
  } else if (const auto* aliked = std::get_if<AlikedArchitecture>(&architecture)) {
    text << "ALIKED, widths " << metadata.at("widths") << ", descriptors of "
         << aliked->descriptor_size << " from " << aliked->samples << " positions";
  }
  return text.str();
}

Json ToJson(const Network& network) {
  Json json;
  if (const auto* superpoint = std::get_if<SuperPointArchitecture>(&network.architecture)) {
    json = {{"network", "superpoint"},
            {"widths", superpoint->widths},
            {"detector_width", superpoint->detector_width},
            {"descriptor_width", superpoint->descriptor_width},
            {"descriptor_size", superpoint->descriptor_size},
            {"affine_layers", superpoint->affine_layers}};
  } else if (const auto* superglue = std::get_if<SuperGlueArchitecture>(&network.architecture)) {
    json = {{"network", "superglue"},
            {"keypoint_encoder", superglue->keypoint_encoder},
            {"descriptor_size", superglue->descriptor_size},
            {"layers", superglue->layers},
            {"heads", superglue->heads},
            {"heads_assumed", superglue->heads_assumed}};
  } else if (const auto* lightglue = std::get_if<LightGlueArchitecture>(&network.architecture)) {
    json = {{"network", "lightglue"},    {"descriptor_size", lightglue->descriptor_size},
            {"size", lightglue->size},   {"layers", lightglue->layers},
            {"heads", lightglue->heads}, {"adaptive_depth", lightglue->adaptive_depth}};
  } else if (const auto* aliked = std::get_if<AlikedArchitecture>(&network.architecture)) {
    json = {{"network", "aliked"},
            {"widths", aliked->widths},
            {"descriptor_size", aliked->descriptor_size},
            {"samples", aliked->samples}};
  }
  json["dialect"] = network.dialect;
  return json;
}

}  // namespace

std::string InspectionText(const std::filesystem::path& path) {
  const Container container = ReadContainer(path);
  const nn::Weights& weights = container.weights;
  const Identity identity = Identify(path, container);
  std::ostringstream text;
  const auto line = [&text](const std::string& name, const std::string& value) {
    text << std::left << std::setw(14) << name << Printable(value) << '\n';
  };
  line("file", weights.source);
  line("sha256", weights.checksum);
  line("form", container.form);
  std::map<std::string, std::string> architecture;
  for (const Network& network : identity.networks) {
    line("architecture", Describe(network.architecture) + " (" + network.dialect + ")");
    architecture.merge(ArchitectureMetadata(network.architecture));
  }
  if (identity.networks.empty()) {
    line("architecture", "unknown: " + identity.problem);
  }
  for (const auto& [name, value] : weights.metadata) {
    if (!architecture.contains(name)) {
      line(name, value);
    }
  }
  line("tensors", std::to_string(weights.tensors.size()));
  line("parameters", std::to_string(CountParameters(weights)));

  std::size_t name_width = 0;
  std::size_t shape_width = 0;
  for (const auto& [name, tensor] : weights.tensors) {
    name_width = std::max(name_width, name.size());
    shape_width = std::max(shape_width, tensor.shape().ToString().size());
  }
  text << '\n';
  for (const auto& [name, tensor] : weights.tensors) {
    text << std::left << std::setw(static_cast<int>(name_width)) << Printable(name) << "  "
         << std::setw(static_cast<int>(shape_width)) << tensor.shape().ToString() << std::right;
    if (tensor.size() > 0) {
      const auto [least, most] = std::minmax_element(tensor.data(), tensor.data() + tensor.size());
      text << std::setprecision(4) << std::setw(12) << *least << " .. " << *most;
    }
    text << '\n';
  }
  return text.str();
}

std::string InspectionJson(const std::filesystem::path& path) {
  const Container container = ReadContainer(path);
  const nn::Weights& weights = container.weights;
  const Identity identity = Identify(path, container);
  Json json;
  json["file"] = weights.source;
  json["sha256"] = weights.checksum;
  json["form"] = container.form;
  json["networks"] = Json::array();
  for (const Network& network : identity.networks) {
    json["networks"].push_back(ToJson(network));
  }
  json["architecture"] = identity.networks.empty() ? Json(nullptr) : json["networks"][0];
  if (identity.networks.empty()) {
    json["problem"] = identity.problem;
  }
  for (const char* name : {"source", "licence", "note"}) {
    const auto found = weights.metadata.find(name);
    json[name] = found == weights.metadata.end() ? Json(nullptr) : Json(found->second);
  }
  json["metadata"] = weights.metadata;
  json["parameters"] = CountParameters(weights);
  json["tensors"] = Json::array();
  for (const auto& [name, tensor] : weights.tensors) {
    Json entry = {{"name", name}, {"shape", Json::array()}};
    for (int axis = 0; axis < tensor.shape().rank(); ++axis) {
      entry["shape"].push_back(tensor.extent(axis));
    }
    entry["minimum"] = nullptr;
    entry["maximum"] = nullptr;
    if (tensor.size() > 0) {
      const auto [least, most] = std::minmax_element(tensor.data(), tensor.data() + tensor.size());
      entry["minimum"] = *least;
      entry["maximum"] = *most;
    }
    json["tensors"].push_back(std::move(entry));
  }
  // Names of .npz entries and paths need not be UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace gluevo::weights_tools
