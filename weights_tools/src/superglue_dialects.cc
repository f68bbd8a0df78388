#include "superglue_dialects.h"

#include <algorithm>
#include <map>
#include <utility>

#include "batch_norm.h"
#include "reshape.h"

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Tensor;

/// Canonical channel d * heads + head is channel head * size + d here.
int64_t ChannelHeadAfterHead(int64_t canonical, int64_t heads, int64_t channels) {
  return canonical % heads * (channels / heads) + canonical / heads;
}

Tensor<float> PermuteRows(const Tensor<float>& tensor, int64_t heads) {
  Tensor<float> permuted(tensor.shape());
  const int64_t rows = tensor.extent(0);
  const int64_t row = rows == 0 ? 0 : tensor.size() / rows;
  for (int64_t i = 0; i < rows; ++i) {
    std::copy_n(tensor.data() + ChannelHeadAfterHead(i, heads, rows) * row, row,
                permuted.data() + i * row);
  }
  return permuted;
}

Tensor<float> PermuteColumns(const Tensor<float>& tensor, int64_t heads) {
  Tensor<float> permuted(tensor.shape());
  const int64_t columns = tensor.extent(1);
  for (int64_t i = 0; i < tensor.size(); ++i) {
    permuted[i] = tensor[i - i % columns + ChannelHeadAfterHead(i % columns, heads, columns)];
  }
  return permuted;
}

// The parts of a module's name that are taken from or put to another name.
constexpr const char* kLinearParts[] = {".weight", ".bias"};
constexpr const char* kNormParts[] = {".weight", ".bias", ".running_mean", ".running_var"};

class HuggingFace {
 public:
  HuggingFace(nn::Weights weights, int64_t heads) : weights_(std::move(weights)), heads_(heads) {}

  nn::Weights Translate() {
    int module = 0;
    for (;; ++module) {
      const std::string layer = "keypoint_encoder.encoder." + std::to_string(module);
      if (!weights_.Has(layer + ".linear.weight")) {
        RenameLinear(layer, "kenc.encoder." + std::to_string(3 * module));
        break;
      }
      RenameLinear(layer + ".linear", "kenc.encoder." + std::to_string(3 * module));
      RenameNorm(layer + ".batch_norm", "kenc.encoder." + std::to_string(3 * module + 1));
    }
    for (int i = 0;; ++i) {
      const std::string layer = "gnn.layers." + std::to_string(i) + ".";
      if (!weights_.Has(layer + "attention.self.query.weight")) {
        break;
      }
      const char* projections[] = {"query", "key", "value"};
      for (int projection = 0; projection < 3; ++projection) {
        const std::string from = layer + "attention.self." + projections[projection];
        for (const char* part : kLinearParts) {
          CheckHeads(from + part, 0);
          Tensor<float>& tensor = weights_.tensors.at(from + part);
          tensor = PermuteRows(tensor, heads_);
        }
        RenameLinear(from, layer + "attn.proj." + std::to_string(projection));
      }
      const std::string merge = layer + "attention.output.dense";
      CheckHeads(merge + ".weight", 1);
      Tensor<float>& tensor = weights_.tensors.at(merge + ".weight");
      tensor = PermuteColumns(tensor, heads_);
      RenameLinear(merge, layer + "attn.merge");
      // The second module goes first, as the first's new names would be its old ones.
      RenameLinear(layer + "mlp.1", layer + "mlp.3");
      RenameNorm(layer + "mlp.0.batch_norm", layer + "mlp.1");
      RenameLinear(layer + "mlp.0.linear", layer + "mlp.0");
    }
    RenameLinear("final_projection.final_proj", "final_proj");
    return std::move(weights_);
  }

 private:
  void Rename(const std::string& from, const std::string& to) {
    auto node = weights_.tensors.extract(from);
    if (node.empty()) {
      weights_.Get(from);  // Says that it is missing.
    }
    node.key() = to;
    const std::string source = weights_.source;
    if (!weights_.tensors.insert(std::move(node)).inserted) {
      throw Error(source + ": tensors " + Quoted(from) + " and " + Quoted(to) +
                  " are of two dialects, expected one");
    }
  }
  void RenameLinear(const std::string& from, const std::string& to) {
    for (const char* part : kLinearParts) {
      Rename(from + part, to + part);
    }
  }
  void RenameNorm(const std::string& from, const std::string& to) {
    if (!weights_.Has(from + ".running_mean")) {  // Folded, or else missed later.
      return;
    }
    for (const char* part : kNormParts) {
      Rename(from + part, to + part);
    }
  }
  void CheckHeads(const std::string& name, int axis) const {
    const Shape& shape = weights_.Get(name).shape();
    if (shape.rank() <= axis || shape.rank() > 2 || shape[axis] % heads_ != 0) {
      throw Error(weights_.source + ": tensor " + Quoted(name) + " of shape " + shape.ToString() +
                  " does not divide into " + std::to_string(heads_) + " heads");
    }
  }

  nn::Weights weights_;
  int64_t heads_;
};

void UsePublishedShapes(nn::Weights& weights) {
  for (auto& [name, tensor] : weights.tensors) {
    if (name == "bin_score" && tensor.shape() == Shape{1}) {
      tensor = Reshaped(tensor, Shape{});
    } else if (tensor.shape().rank() == 2) {
      tensor = Reshaped(tensor, Shape{tensor.extent(0), tensor.extent(1), 1});
    }
  }
}

bool HasAnyBatchNorm(const nn::Weights& weights) {
  return std::any_of(weights.tensors.begin(), weights.tensors.end(),
                     [](const auto& entry) { return entry.first.ends_with(".running_mean"); });
}

// Names of the modules that have batch norms behind them, with the batch norms' names.
std::map<std::string, std::string> NormedModules(const nn::Weights& weights) {
  std::map<std::string, std::string> modules;
  const auto module = [](int i) { return "kenc.encoder." + std::to_string(i); };
  for (int i = 0; weights.Has(module(i + 3) + ".weight"); i += 3) {
    modules[module(i)] = module(i + 1);
  }
  for (int i = 0;; ++i) {
    const std::string layer = "gnn.layers." + std::to_string(i) + ".mlp.";
    if (!weights.Has(layer + "0.weight")) {
      return modules;
    }
    modules[layer + "0"] = layer + "1";
  }
}

}  // namespace

std::optional<TranslatedSuperGlue> TranslateSuperGlue(nn::Weights weights, int64_t heads,
                                                      std::optional<double> epsilon) {
  TranslatedSuperGlue translated;
  if (weights.Has("kenc.encoder.0.weight")) {
    translated = {std::move(weights), "magic-leap"};
  } else if (weights.Has("keypoint_encoder.encoder.0.linear.weight") ||
             weights.Has("keypoint_encoder.encoder.0.weight")) {
    translated = {HuggingFace(std::move(weights), heads).Translate(), "hugging-face"};
  } else {
    return std::nullopt;
  }
  UsePublishedShapes(translated.weights);
  const bool folded = !HasAnyBatchNorm(translated.weights);
  for (const auto& [module, norm] : NormedModules(translated.weights)) {
    if (folded) {
      const Shape& shape = translated.weights.Get(module + ".weight").shape();
      AddIdentityBatchNorm(translated.weights, norm, shape.rank() == 0 ? 0 : shape[0]);
    } else if (epsilon) {
      UseUsualEpsilon(translated.weights, norm, *epsilon);
    }
  }
  return translated;
}

}  // namespace gluevo::weights_tools
