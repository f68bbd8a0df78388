#include "lightglue_dialects.h"

#include <string>
#include <string_view>
#include <utility>

namespace gluevo::weights_tools {
namespace {

// "self_attn.0.Wqkv.weight" to "transformers.0.self_attn.Wqkv.weight"; others as they are.
std::string Nested(const std::string& name) {
  for (const std::string_view block : {"self_attn.", "cross_attn."}) {
    const std::size_t dot = name.find('.', block.size());
    if (name.starts_with(block) && dot != std::string::npos) {
      return "transformers." + name.substr(block.size(), dot + 1 - block.size()) +
             std::string(block) + name.substr(dot + 1);
    }
  }
  return name;
}

}  // namespace

CanonicalNetwork TranslateLightGlue(nn::Weights weights) {
  const bool flat = weights.Has("self_attn.0.Wqkv.weight");
  CanonicalNetwork network{std::move(weights), flat ? "lightglue-flat" : "lightglue"};
  if (!flat) {
    return network;
  }
  std::map<std::string, nn::Tensor<float>> tensors;
  for (auto& [name, tensor] : network.weights.tensors) {
    if (name.starts_with("log_assignment.") && name.ends_with(".r")) {
      continue;
    }
    if (!tensors.emplace(Nested(name), std::move(tensor)).second) {
      throw Error(network.weights.source + ": tensor " + Quoted(name) +
                  " is the second that means " + Quoted(Nested(name)));
    }
  }
  network.weights.tensors = std::move(tensors);
  return network;
}

}  // namespace gluevo::weights_tools
