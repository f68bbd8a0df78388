#include "dialects.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "superglue_dialects.h"
#include "superpoint_dialects.h"

namespace gluevo::weights_tools {
namespace {

std::string WithoutWrappings(std::string_view name) {
  constexpr std::array<std::string_view, 12> kWrappings = {
      "module.",     "_orig_mod.", "net.",       "model.",   "network.",    "matching.",
      "superpoint.", "superglue.", "extractor.", "matcher.", "state_dict.", "keypoint_detector."};
  for (bool found = true; found;) {
    found = false;
    for (const std::string_view wrapping : kWrappings) {
      if (name.starts_with(wrapping)) {
        name.remove_prefix(wrapping.size());
        found = true;
      }
    }
  }
  return std::string(name);
}

void RemoveWrappings(nn::Weights& weights) {
  std::map<std::string, nn::Tensor<float>> tensors;
  for (auto& [name, tensor] : weights.tensors) {
    const std::string inner = WithoutWrappings(name);
    if (!tensors.emplace(inner, std::move(tensor)).second) {
      throw Error(weights.source + ": tensor " + Quoted(name) + " is the second that means " +
                  Quoted(inner));
    }
  }
  weights.tensors = std::move(tensors);
}

bool IsSuperGlueName(std::string_view name) {
  constexpr std::array<std::string_view, 6> kStarts = {
      "kenc.", "gnn.", "final_proj.", "bin_score", "keypoint_encoder.", "final_projection."};
  return std::any_of(kStarts.begin(), kStarts.end(),
                     [name](std::string_view start) { return name.starts_with(start); });
}

}  // namespace

std::vector<CanonicalNetwork> ToCanonical(Container container, int64_t heads) {
  nn::Weights& all = container.weights;
  RemoveWrappings(all);
  nn::Weights superglue{.source = all.source, .checksum = all.checksum, .metadata = all.metadata};
  for (auto it = all.tensors.begin(); it != all.tensors.end();) {
    const auto next = std::next(it);
    if (IsSuperGlueName(it->first)) {
      superglue.tensors.insert(all.tensors.extract(it));
    }
    it = next;
  }

  std::vector<CanonicalNetwork> networks;
  if (std::optional<TranslatedSuperPoint> translated =
          TranslateSuperPoint(all, container.batch_norm_epsilon)) {
    networks.push_back({std::move(translated->weights), translated->dialect});
  } else {
    // For the check of the SuperGlue to name.
    superglue.tensors.merge(all.tensors);
  }
  if (std::any_of(superglue.tensors.begin(), superglue.tensors.end(),
                  [](const auto& entry) { return IsSuperGlueName(entry.first); })) {
    if (std::optional<TranslatedSuperGlue> translated =
            TranslateSuperGlue(superglue, heads, container.batch_norm_epsilon)) {
      networks.push_back({std::move(translated->weights), translated->dialect});
    } else {
      throw Error(superglue.source +
                  ": a SuperGlue without a keypoint encoder: there is no tensor " +
                  "\"kenc.encoder.0.weight\"");
    }
  }
  if (networks.empty()) {
    throw Error(
        superglue.source +
        ": is neither a SuperPoint nor a SuperGlue that is known: there is no tensor "
        "\"conv1a.weight\" nor \"kenc.encoder.0.weight\", nor what other dialects call them");
  }
  return networks;
}

}  // namespace gluevo::weights_tools
