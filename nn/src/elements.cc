#include "gluevo/nn/elements.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

namespace gluevo::nn {
namespace {

[[noreturn]] void RefuseValue(const Bytes& bytes, uint64_t at, const std::string& name,
                              float value) {
  bytes.Fail(at, "tensor " + Quoted(name) + " holds " +
                     (std::isnan(value) ? "NaN" : "an infinite value") +
                     ", expected finite weights");
}

template <typename Stored, typename Widen>
float ReadValue(const Bytes& bytes, uint64_t at, const std::string& name, Widen widen) {
  Stored stored;
  std::memcpy(&stored, bytes.data() + at, sizeof(Stored));
  const float value = widen(stored);
  if (!std::isfinite(value)) {
    RefuseValue(bytes, at, name, value);
  }
  return value;
}

template <typename Stored, typename Widen>
void ReadRow(const Bytes& bytes, uint64_t first, int64_t stride, int64_t count,
             const std::string& name, float* to, Widen widen) {
  for (int64_t i = 0; i < count; ++i) {
    to[i] = ReadValue<Stored>(bytes, (first + static_cast<uint64_t>(i * stride)) * sizeof(Stored),
                              name, widen);
  }
}

// The conversion itself is undefined for a value beyond float's range.
float Narrow(double value) {
  if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
    return std::numeric_limits<float>::infinity();
  }
  return static_cast<float>(value);
}

bool InOrder(const Shape& shape, const Strides& strides) {
  const Strides expected = RowMajorStrides(shape);
  for (int axis = 0; axis < shape.rank(); ++axis) {
    if (shape[axis] > 1 && strides[axis] != expected[axis]) {
      return false;
    }
  }
  return true;
}

// Refuses elements outside the storage; the shape is of one element at least.
void CheckReach(const Bytes& storage, ElementType type, const Shape& shape, const Strides& strides,
                uint64_t offset, const std::string& name) {
  const uint64_t there = storage.size() / ElementSize(type);
  if (static_cast<uint64_t>(shape.size()) > there) {
    storage.Fail(0, "tensor " + Quoted(name) + " of shape " + shape.ToString() +
                        " has more elements than its storage, which has " + std::to_string(there));
  }
  const auto refuse = [&] {
    storage.Fail(0, "tensor " + Quoted(name) + " of shape " + shape.ToString() +
                        " reaches beyond its storage of " + std::to_string(there) + " elements");
  };
  if (offset >= there) {
    refuse();
  }
  uint64_t last = offset;
  for (int axis = 0; axis < shape.rank(); ++axis) {
    if (strides[axis] < 0) {
      storage.Fail(0, "tensor " + Quoted(name) + " has a negative stride");
    }
    const auto steps = static_cast<uint64_t>(shape[axis] - 1);
    const auto stride = static_cast<uint64_t>(strides[axis]);
    // A product beyond the storage is refused before it can overflow.
    if (steps > 0 && stride > (there - 1 - last) / steps) {
      refuse();
    }
    last += steps * stride;
  }
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

Strides RowMajorStrides(const Shape& shape) {
  Strides strides = {};
  int64_t stride = 1;
  for (int axis = shape.rank() - 1; axis >= 0; --axis) {
    strides[axis] = stride;
    stride *= shape[axis];
  }
  return strides;
}

Tensor<float> ReadStrided(const Bytes& storage, ElementType type, const Shape& shape,
                          const Strides& strides, uint64_t offset, const std::string& name) {
  if (shape.size() > 0) {
    CheckReach(storage, type, shape, strides, offset, name);
  }
  Tensor<float> tensor(shape);
  // Elements in their order are one long row.
  const bool in_order = InOrder(shape, strides);
  const int inner = in_order ? 0 : shape.rank() - 1;
  const int64_t row = in_order ? shape.size() : shape[inner];
  const int64_t step = in_order ? 1 : strides[inner];
  int64_t index[Shape::kMaxRank] = {};
  for (int64_t done = 0; done < tensor.size(); done += row) {
    uint64_t first = offset;
    for (int axis = 0; axis < inner; ++axis) {
      first += static_cast<uint64_t>(index[axis] * strides[axis]);
    }
    float* const to = tensor.data() + done;
    switch (type) {
      case ElementType::kF16:
        ReadRow<uint16_t>(storage, first, step, row, name, to, HalfToFloat);
        break;
      case ElementType::kBF16:
        ReadRow<uint16_t>(storage, first, step, row, name, to, Bfloat16ToFloat);
        break;
      case ElementType::kF32:
        ReadRow<float>(storage, first, step, row, name, to, [](float value) { return value; });
        break;
      case ElementType::kF64:
        ReadRow<double>(storage, first, step, row, name, to, Narrow);
        break;
    }
    for (int axis = inner - 1; axis >= 0 && ++index[axis] == shape[axis]; --axis) {
      index[axis] = 0;
    }
  }
  return tensor;
}

Tensor<float> ReadElements(const Bytes& bytes, ElementType type, const Shape& shape,
                           const std::string& name) {
  const uint64_t needed = static_cast<uint64_t>(shape.size()) * ElementSize(type);
  if (bytes.size() != needed) {
    bytes.Fail(0, "tensor " + Quoted(name) + " of shape " + shape.ToString() + " has " +
                      std::to_string(bytes.size()) + " bytes, expected " + std::to_string(needed));
  }
  return ReadStrided(bytes, type, shape, RowMajorStrides(shape), 0, name);
}

bool IsTrainingCounter(const std::string& name) {
  return std::string_view(name).ends_with("num_batches_tracked");
}

}  // namespace gluevo::nn
