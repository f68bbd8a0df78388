#include "gluevo/nn/weights.h"

#include <string_view>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/foreign_file.h"
#include "gluevo/nn/input_file.h"
#include "gluevo/nn/npy.h"
#include "npz.h"
#include "safetensors.h"

namespace gluevo::nn {
namespace {

bool StartsWith(const Bytes& file, std::string_view start) {
  return std::string_view(reinterpret_cast<const char*>(file.data()), file.size())
      .starts_with(start);
}

}  // namespace

const Tensor<float>& Weights::Get(const std::string& name) const {
  const auto found = tensors.find(name);
  if (found == tensors.end()) {
    throw Error(source + ": there is no tensor " + Quoted(name));
  }
  return found->second;
}

const Tensor<float>& Weights::Get(const std::string& name, const Shape& expected) const {
  const Tensor<float>& tensor = Get(name);
  CheckShape(tensor.shape(), expected, source + ": tensor " + Quoted(name));
  return tensor;
}

Weights ParseWeights(const void* bytes, std::size_t size, const std::string& source) {
  const Bytes file(bytes, size, source);
  Weights weights;
  weights.source = source;
  if (size == 0) {
    file.Fail(0, "the file is empty, expected .safetensors or .npz");
  }
  if (const std::optional<std::string> form = ForeignForm(file, ".safetensors or .npz")) {
    file.Fail(0, "the file is " + *form);
  }
  // The two ways to safetensors are apart because a header's length may read "PK".
  if (LooksLikeSafetensors(file)) {  // NOLINT(bugprone-branch-clone)
    ParseSafetensors(file, weights);
  } else if (StartsWith(file, "PK")) {
    ParseNpz(file, weights);
  } else if (LooksLikeNpy(file)) {
    file.Fail(0, "the file is a single .npy array, expected .safetensors or .npz");
  } else if (size <= 8 || file.data()[8] == '{' || file.U32(4, "") == 0) {
    // Meant as safetensors: says what is wrong with the header.
    ParseSafetensors(file, weights);
  } else {
    file.Fail(0, "the file is neither .safetensors nor .npz (gluevo-weights converts other forms)");
  }
  weights.checksum = Sha256(bytes, size);
  return weights;
}

Weights ReadWeights(const std::filesystem::path& path) {
  const InputFile file = ReadInputFile(path);
  return ParseWeights(file.data.get(), file.size, path.string());
}

}  // namespace gluevo::nn
