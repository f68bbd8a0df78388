#include "png_chunks.h"

#define ZLIB_CONST  // zlib then takes its input as constant.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

namespace gluevo::vo {
namespace {

constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::size_t kLengthSize = 4;
constexpr std::size_t kNameSize = 4;
constexpr std::size_t kChecksumSize = 4;
constexpr std::size_t kFrame = kLengthSize + kNameSize + kChecksumSize;

uint32_t NumberAt(const unsigned char* bytes) {
  return static_cast<uint32_t>(bytes[0]) << 24U | static_cast<uint32_t>(bytes[1]) << 16U |
         static_cast<uint32_t>(bytes[2]) << 8U | static_cast<uint32_t>(bytes[3]);
}

bool HasRightChecksum(const unsigned char* name, std::size_t length) {
  const uLong checksum = crc32_z(crc32(0, nullptr, 0), name, kNameSize + length);
  return checksum == NumberAt(name + kNameSize + length);
}

// Decoders cannot do without those whose name begins with a capital letter.
bool IsCritical(const unsigned char* name) { return (name[0] & 0x20U) == 0; }

}  // namespace

bool IsPng(const ImageBytes& bytes) {
  return bytes.size() >= kSignature.size() &&
         std::equal(kSignature.begin(), kSignature.end(), bytes.begin());
}

ImageBytes SoundPng(ImageBytes bytes) {
  bool has_pixels = false;
  for (std::size_t at = kSignature.size(); bytes.size() - at >= kFrame;) {
    const unsigned char* const chunk = bytes.data() + at;
    const std::size_t length = NumberAt(chunk);
    if (length > bytes.size() - at - kFrame) {
      return {};
    }
    const unsigned char* const name = chunk + kLengthSize;
    const std::size_t end = at + kFrame + length;
    if (!HasRightChecksum(name, length)) {
      if (IsCritical(name)) {
        return {};
      }
      bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                  bytes.begin() + static_cast<std::ptrdiff_t>(end));
      continue;
    }
    const std::string_view kind(reinterpret_cast<const char*>(name), kNameSize);
    has_pixels = has_pixels || (kind == "IDAT" && length > 0);
    if ((at == kSignature.size()) != (kind == "IHDR")) {
      return {};
    }
    if (kind == "IEND") {
      return has_pixels ? std::move(bytes) : ImageBytes();
    }
    at = end;
  }
  return {};
}

}  // namespace gluevo::vo
