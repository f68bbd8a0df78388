#include "dialects.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>

#include "lightglue_dialects.h"
#include "superglue_dialects.h"
#include "superpoint_dialects.h"

namespace gluevo::weights_tools {
namespace {

// How the first layer is called in each dialect.
constexpr std::array<std::string_view, 8> kFirstLayers = {
    "conv1a.",         "encoder.conv_blocks.0.conv_a.", "backbone.0.0.conv.", "inc.conv.conv.0.",
    "kenc.encoder.0.", "keypoint_encoder.encoder.0.",   "posenc.Wr.",         "block1.conv1."};

constexpr std::size_t kMostWrappings = 16;

// What stands before the names of first layers: of a program's modules that hold a network, and of
// the wrappings that training puts around it.
std::set<std::string> WrappingsOf(const nn::Weights& weights) {
  std::set<std::string> wrappings;
  for (const auto& [name, tensor] : weights.tensors) {
    for (const std::string_view layer : kFirstLayers) {
      const std::size_t at = name.find(layer);
      if (at != std::string::npos && at > 0 && name[at - 1] == '.') {
        wrappings.insert(name.substr(0, at));
        if (wrappings.size() > kMostWrappings) {
          throw Error(weights.source + ": holds more than " + std::to_string(kMostWrappings) +
                      " networks, expected a SuperPoint, a SuperGlue or one of each");
        }
      }
    }
  }
  return wrappings;
}

std::string WithoutWrapping(const std::string& name, const std::set<std::string>& wrappings) {
  std::size_t longest = 0;
  for (const std::string& wrapping : wrappings) {
    longest = name.starts_with(wrapping) ? std::max(longest, wrapping.size()) : longest;
  }
  return name.substr(longest);
}

void RemoveWrappings(nn::Weights& weights) {
  const std::set<std::string> wrappings = WrappingsOf(weights);
  std::map<std::string, nn::Tensor<float>> tensors;
  for (auto& [name, tensor] : weights.tensors) {
    const std::string inner = WithoutWrapping(name, wrappings);
    if (!tensors.emplace(inner, std::move(tensor)).second) {
      throw Error(weights.source + ": tensor " + Quoted(name) + " is the second that means " +
                  Quoted(inner));
    }
  }
  weights.tensors = std::move(tensors);
}

// Matchers of which no form is known here, by a part of a name that only they have.
void RefuseOtherMatchers(const nn::Weights& weights) {
  constexpr std::array<std::pair<std::string_view, const char*>, 2> kOthers = {
      {{"transformer_layers.0.self_attention.q_proj.", "LightGlue in Hugging Face's form"},
       {"loftr_coarse.layers.0.", "LoFTR"}}};
  for (const auto& [name, tensor] : weights.tensors) {
    for (const auto& [part, network] : kOthers) {
      if (name.find(part) != std::string::npos) {
        throw Error(
            weights.source + ": is a " + network + " (tensor " + Quoted(name) +
            "), expected a SuperPoint, a SuperGlue, an ALIKED or a LightGlue under its published " +
            "names");
      }
    }
  }
}

constexpr std::array<std::string_view, 6> kSuperGlueStarts = {
    "kenc.", "gnn.", "final_proj.", "bin_score", "keypoint_encoder.", "final_projection."};

bool IsSuperGlueName(std::string_view name) {
  return std::any_of(kSuperGlueStarts.begin(), kSuperGlueStarts.end(),
                     [name](std::string_view start) { return name.starts_with(start); });
}

// Takes the tensors whose names start so out of the others.
template <std::size_t kCount>
nn::Weights Extract(nn::Weights& all, const std::array<std::string_view, kCount>& starts) {
  nn::Weights part{.source = all.source, .checksum = all.checksum, .metadata = all.metadata};
  for (auto it = all.tensors.begin(); it != all.tensors.end();) {
    const auto next = std::next(it);
    if (std::any_of(starts.begin(), starts.end(), [&](std::string_view start) {
          return std::string_view(it->first).starts_with(start);
        })) {
      part.tensors.insert(all.tensors.extract(it));
    }
    it = next;
  }
  return part;
}

}  // namespace

std::vector<CanonicalNetwork> ToCanonical(Container container, int64_t heads) {
  nn::Weights& all = container.weights;
  RefuseOtherMatchers(all);
  RemoveWrappings(all);
  constexpr std::array<std::string_view, 7> kLightGlue = {
      "posenc.",     "input_proj.",     "transformers.",    "self_attn.",
      "cross_attn.", "log_assignment.", "token_confidence."};
  constexpr std::array<std::string_view, 10> kAliked = {
      "block1.", "block2.", "block3.", "block4.",     "conv1.",
      "conv2.",  "conv3.",  "conv4.",  "score_head.", "desc_head."};
  std::vector<CanonicalNetwork> open_networks;
  if (all.Has("desc_head.agg_weights")) {
    open_networks.push_back({Extract(all, kAliked), "aliked"});
  }
  if (all.Has("posenc.Wr.weight")) {
    open_networks.push_back(TranslateLightGlue(Extract(all, kLightGlue)));
  }
  nn::Weights superglue = Extract(all, kSuperGlueStarts);

  std::vector<CanonicalNetwork> networks;
  if (std::optional<TranslatedSuperPoint> translated =
          TranslateSuperPoint(all, container.batch_norm_epsilon)) {
    networks.push_back({std::move(translated->weights), translated->dialect});
  } else {
    // For the check of another network to name.
    (open_networks.empty() ? superglue : open_networks.front().weights).tensors.merge(all.tensors);
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
  std::move(open_networks.begin(), open_networks.end(), std::back_inserter(networks));
  if (networks.empty()) {
    throw Error(
        superglue.source +
        ": is neither a SuperPoint nor a SuperGlue, a LightGlue nor an ALIKED that is known: there "
        "is no tensor \"conv1a.weight\", \"kenc.encoder.0.weight\", \"posenc.Wr.weight\" nor "
        "\"desc_head.agg_weights\", nor what other dialects call them");
  }
  return networks;
}

}  // namespace gluevo::weights_tools
