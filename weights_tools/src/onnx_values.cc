#include <algorithm>
#include <cstring>
#include <limits>

#include "gluevo/nn/elements.h"
#include "onnx_model.h"

namespace gluevo::weights_tools {
namespace {

using nn::ElementType;
using nn::Shape;
using nn::Tensor;

// TensorProto.DataType.
constexpr uint64_t kFloat = 1;
constexpr uint64_t kUint8 = 2;
constexpr uint64_t kInt8 = 3;
constexpr uint64_t kInt32 = 6;
constexpr uint64_t kFloat16 = 10;
constexpr uint64_t kDouble = 11;
constexpr uint64_t kBfloat16 = 16;

std::string Subject(const OnnxTensor& tensor) { return "tensor " + Quoted(tensor.name); }

Shape ShapeOf(const OnnxTensor& tensor) {
  std::vector<int64_t> extents;
  for (const uint64_t extent : tensor.dims) {
    constexpr uint64_t kLargest = std::numeric_limits<int64_t>::max();
    extents.push_back(static_cast<int64_t>(std::min(extent, kLargest)));
  }
  try {
    return {extents.data(), extents.size()};
  } catch (const Error& error) {
    tensor.message.Fail(0, Subject(tensor) + ": " + error.what());
  }
}

template <typename Integer>
Tensor<float> Integers(const OnnxTensor& tensor, const Shape& shape) {
  const uint64_t count = tensor.raw ? tensor.raw->size() / sizeof(Integer)  //
                                    : tensor.integers.size();
  if (count != static_cast<uint64_t>(shape.size()) ||
      (tensor.raw && tensor.raw->size() % sizeof(Integer) != 0)) {
    tensor.message.Fail(0, Subject(tensor) + " of shape " + shape.ToString() + " has " +
                               std::to_string(count) + " values, expected " +
                               std::to_string(shape.size()));
  }
  Tensor<float> values(shape);
  for (int64_t i = 0; i < shape.size(); ++i) {
    Integer value;
    if (tensor.raw) {
      std::memcpy(&value, tensor.raw->data() + static_cast<uint64_t>(i) * sizeof(Integer),
                  sizeof(Integer));
    } else {
      value = static_cast<Integer>(tensor.integers[static_cast<std::size_t>(i)]);
    }
    values[i] = static_cast<float>(value);
  }
  return values;
}

// Half and bfloat16 that come as numbers rather than as bytes.
Tensor<float> FromBits(const OnnxTensor& tensor, const Shape& shape, ElementType type) {
  std::vector<uint16_t> bits;
  bits.reserve(tensor.integers.size());
  for (const uint64_t number : tensor.integers) {
    bits.push_back(static_cast<uint16_t>(number));
  }
  // Their own place in the file is lost, the message's is near.
  const nn::Bytes bytes = tensor.message.Inflated(bits.data(), bits.size() * sizeof(uint16_t));
  return nn::ReadElements(bytes, type, shape, tensor.name);
}

Tensor<float> Reals(const OnnxTensor& tensor, const Shape& shape, ElementType type) {
  if (tensor.raw) {
    return nn::ReadElements(*tensor.raw, type, shape, tensor.name);
  }
  if (type == ElementType::kF32 && (tensor.floats || shape.size() == 0)) {
    return nn::ReadElements(tensor.floats.value_or(tensor.message.Slice(0, 0, "")), type, shape,
                            tensor.name);
  }
  if (type == ElementType::kF64) {
    tensor.message.Fail(0, Subject(tensor) + " has no raw data");
  }
  return FromBits(tensor, shape, type);
}

}  // namespace

Tensor<float> OnnxValues(const OnnxTensor& tensor) {
  if (tensor.external) {
    tensor.message.Fail(0, Subject(tensor) +
                               " is kept in another file: save the model with all its weights "
                               "inside (onnx.save, save_as_external_data=False)");
  }
  const Shape shape = ShapeOf(tensor);
  switch (tensor.type) {
    case kFloat:
      return Reals(tensor, shape, ElementType::kF32);
    case kFloat16:
      return Reals(tensor, shape, ElementType::kF16);
    case kBfloat16:
      return Reals(tensor, shape, ElementType::kBF16);
    case kDouble:
      return Reals(tensor, shape, ElementType::kF64);
    case kInt8:
      return Integers<int8_t>(tensor, shape);
    case kUint8:
      return Integers<uint8_t>(tensor, shape);
    case kInt32:
      return Integers<int32_t>(tensor, shape);
    default:
      tensor.message.Fail(0, Subject(tensor) + " has element type " + std::to_string(tensor.type) +
                                 " of ONNX, expected float, double, half, bfloat16, int8, uint8 or "
                                 "int32");
  }
}

}  // namespace gluevo::weights_tools
