#include "elements.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

namespace gluevo::nn {
namespace {

template <typename Stored, typename Widen>
void Read(const Bytes& bytes, const std::string& name, Tensor<float>& tensor, Widen widen) {
  if (bytes.size() != static_cast<uint64_t>(tensor.size()) * sizeof(Stored)) {
    bytes.Fail(0, "tensor " + Quoted(name) + " of shape " + tensor.shape().ToString() + " has " +
                      std::to_string(bytes.size()) + " bytes, expected " +
                      std::to_string(static_cast<uint64_t>(tensor.size()) * sizeof(Stored)));
  }
  for (int64_t i = 0; i < tensor.size(); ++i) {
    Stored stored;
    std::memcpy(&stored, bytes.data() + i * sizeof(Stored), sizeof(Stored));
    const float value = widen(stored);
    if (!std::isfinite(value)) {
      bytes.Fail(i * sizeof(Stored), "tensor " + Quoted(name) + " holds " +
                                         (std::isnan(value) ? "NaN" : "an infinite value") +
                                         ", expected finite weights");
    }
    tensor[i] = value;
  }
}

// The conversion itself is undefined for a value beyond float's range.
float Narrow(double value) {
  if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
    return std::numeric_limits<float>::infinity();
  }
  return static_cast<float>(value);
}

}  // namespace

std::size_t ElementSize(ElementType type) {
  switch (type) {
    case ElementType::kF16:
    case ElementType::kBF16:
      return 2;
    case ElementType::kF32:
      return 4;
    case ElementType::kF64:
      return 8;
  }
  throw Error("an element type that does not exist");
}

Tensor<float> ReadElements(const Bytes& bytes, ElementType type, const Shape& shape,
                           const std::string& name) {
  Tensor<float> tensor(shape);
  switch (type) {
    case ElementType::kF16:
      Read<uint16_t>(bytes, name, tensor, HalfToFloat);
      break;
    case ElementType::kBF16:
      Read<uint16_t>(bytes, name, tensor, Bfloat16ToFloat);
      break;
    case ElementType::kF32:
      Read<float>(bytes, name, tensor, [](float value) { return value; });
      break;
    case ElementType::kF64:
      Read<double>(bytes, name, tensor, Narrow);
      break;
  }
  return tensor;
}

bool IsTrainingCounter(const std::string& name) {
  return std::string_view(name).ends_with("num_batches_tracked");
}

}  // namespace gluevo::nn
