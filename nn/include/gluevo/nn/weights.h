#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "gluevo/nn/tensor.h"

namespace gluevo::nn {

/// The tensors of one network by name, as read from a weights file (names and shapes as in the
/// published checkpoints: "conv1a.weight" [64 x 1 x 3 x 3], ...). Half and bfloat16 values are
/// widened to float.
struct Weights {
  /// Path (or "built-in NAME") for messages and records.
  std::string source;
  /// SHA-256 of the file's bytes, lower-case hexadecimal.
  std::string checksum;
  /// safetensors' __metadata__; empty for .npz.
  std::map<std::string, std::string> metadata;
  std::map<std::string, Tensor<float>> tensors;

  bool Has(const std::string& name) const { return tensors.contains(name); }
  /// Throws Error naming the file and the tensor where it is missing.
  const Tensor<float>& Get(const std::string& name) const;
  /// The same, and throws Error where its shape is another.
  const Tensor<float>& Get(const std::string& name, const Shape& expected) const;
};

/// Reads a .safetensors or .npz file; which of the two is told by its first bytes, not its name.
/// Throws Error with file and byte offset for anything malformed: sizes and offsets out of bounds,
/// gaps, overlaps, duplicate names, trailing bytes, NaN and infinity, element types other than F32,
/// F16, BF16 and F64, which is narrowed to float (for .npz see npy.h). The integer counters
/// "....num_batches_tracked" that published checkpoints carry from training are left out.
Weights ReadWeights(const std::filesystem::path& path);

/// The same from memory; `source` names it in messages.
Weights ParseWeights(const void* bytes, std::size_t size, const std::string& source);

/// Writes F32 safetensors: tensors in the order of their names, a deterministic header, 8-byte
/// aligned data; beside its place first, then renamed. Throws Error where it cannot be written and
/// for what could not be read back: NaN, infinity, names that are not UTF-8.
void WriteSafetensors(const std::filesystem::path& path, const Weights& weights);

/// The project's own open weights, carried inside the library (see nn/open_weights/README.md).
Weights OpenSuperPointWeights();
Weights OpenSuperGlueWeights();
/// Typical descriptors of the built-in SuperPoint, for place recognition.
Weights OpenPlaceCodebook();

}  // namespace gluevo::nn
