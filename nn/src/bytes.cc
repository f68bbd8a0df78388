#include "gluevo/nn/bytes.h"

#include <cstring>

#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

template <typename T>
T Load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

}  // namespace

Bytes Bytes::Slice(uint64_t offset, uint64_t size, const std::string& what) const {
  if (offset > size_ || size > size_ - offset) {
    const uint64_t there = offset > size_ ? 0 : size_ - offset;
    Fail(offset, what + " is cut short: " + std::to_string(size) + " bytes expected, " +
                     std::to_string(there) + " are there");
  }
  Bytes slice = *this;
  slice.data_ += offset;
  slice.size_ = size;
  (inflated_ ? slice.inflated_origin_ : slice.origin_) += offset;
  return slice;
}

uint16_t Bytes::U16(uint64_t offset, const std::string& what) const {
  return Load<uint16_t>(Slice(offset, sizeof(uint16_t), what).data());
}

uint32_t Bytes::U32(uint64_t offset, const std::string& what) const {
  return Load<uint32_t>(Slice(offset, sizeof(uint32_t), what).data());
}

uint64_t Bytes::U64(uint64_t offset, const std::string& what) const {
  return Load<uint64_t>(Slice(offset, sizeof(uint64_t), what).data());
}

Bytes Bytes::Inflated(const void* data, std::size_t size) const {
  Bytes inflated = *this;
  inflated.data_ = static_cast<const unsigned char*>(data);
  inflated.size_ = size;
  inflated.inflated_origin_ = 0;
  inflated.inflated_ = true;
  return inflated;
}

void Bytes::Fail(uint64_t offset, const std::string& message) const {
  std::string place = *source_ + ": byte ";
  if (inflated_) {
    place += std::to_string(origin_) + " (inflated byte " +
             std::to_string(inflated_origin_ + offset) + ")";
  } else {
    place += std::to_string(origin_ + offset);
  }
  throw Error(place + ": " + message);
}

}  // namespace gluevo::nn
