#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace gluevo::nn {

static_assert(std::endian::native == std::endian::little,
              "weights are little-endian and read as they lie in the file");

/// A view of bytes that knows where in which file they lie, so that every read is checked and every
/// error names file and offset. The bytes are somebody else's and must outlive it.
class Bytes {
 public:
  Bytes(const void* data, std::size_t size, const std::string& source)
      : data_(static_cast<const unsigned char*>(data)),
        size_(size),
        source_(std::make_shared<const std::string>(source)) {}

  const unsigned char* data() const { return data_; }
  std::size_t size() const { return size_; }

  /// `size` bytes from `offset` on; throws Error "WHAT is cut short" where they are not there.
  Bytes Slice(uint64_t offset, uint64_t size, const std::string& what) const;
  /// Little-endian numbers; throw Error "WHAT is cut short" where their bytes are not there.
  uint16_t U16(uint64_t offset, const std::string& what) const;
  uint32_t U32(uint64_t offset, const std::string& what) const;
  uint64_t U64(uint64_t offset, const std::string& what) const;

  /// A view of what these bytes inflate to. Its errors name the offset of these bytes in the file
  /// and the offset among the inflated ones.
  Bytes Inflated(const void* data, std::size_t size) const;

  /// Throws Error "FILE: byte OFFSET: MESSAGE"; `offset` counts from the start of this view.
  [[noreturn]] void Fail(uint64_t offset, const std::string& message) const;

 private:
  const unsigned char* data_;
  std::size_t size_;
  std::shared_ptr<const std::string> source_;
  uint64_t origin_ = 0;           // Offset in the file of the first byte.
  uint64_t inflated_origin_ = 0;  // The same in the inflated bytes, where these are inflated.
  bool inflated_ = false;
};

}  // namespace gluevo::nn
