#include "image_bytes.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>

#include "png_chunks.h"

namespace gluevo::vo {
namespace {

bool HasAt(const ImageBytes& bytes, std::size_t offset, std::string_view text) {
  return offset <= bytes.size() && text.size() <= bytes.size() - offset &&
         std::memcmp(bytes.data() + offset, text.data(), text.size()) == 0;
}

// A number of `size` bytes, or nothing beyond the end.
std::optional<std::size_t> NumberAt(const ImageBytes& bytes, std::size_t offset, std::size_t size,
                                    bool little_endian) {
  if (offset > bytes.size() || size > bytes.size() - offset) {
    return std::nullopt;
  }
  std::size_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value = 256 * value + bytes[offset + (little_endian ? size - 1 - i : i)];
  }
  return value;
}

bool IsJpeg(const ImageBytes& bytes) { return HasAt(bytes, 0, "\xFF\xD8"); }
bool IsWebp(const ImageBytes& bytes) { return HasAt(bytes, 0, "RIFF") && HasAt(bytes, 8, "WEBP"); }
bool IsTiffAt(const ImageBytes& bytes, std::size_t offset) {
  using std::string_view_literals::operator""sv;
  return HasAt(bytes, offset, "II*\0"sv) || HasAt(bytes, offset, "MM\0*"sv);
}

// Visits the segments of a JPEG file (marker, offset of what they hold), and tells whether it has
// an end. Thumbnails are JPEG files within a segment: their ends don't count.
bool WalkJpeg(const ImageBytes& bytes,
              const std::function<void(unsigned char marker, std::size_t offset)>& visit) {
  constexpr unsigned char kEnd = 0xD9;
  for (std::size_t at = 2; at + 1 < bytes.size();) {
    if (bytes[at] != 0xFF) {
      const auto next = std::find(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end(),
                                  static_cast<unsigned char>(0xFF));
      at = static_cast<std::size_t>(next - bytes.begin());
      continue;
    }
    const unsigned char marker = bytes[at + 1];
    if (marker == kEnd) {
      return true;
    }
    const bool stands_alone = marker <= 0x01 || (marker >= 0xD0 && marker <= 0xD8);
    if (marker == 0xFF || stands_alone) {
      at += marker == 0xFF ? 1 : 2;
      continue;
    }
    const auto length = NumberAt(bytes, at + 2, 2, /*little_endian=*/false);
    if (!length) {
      return false;
    }
    visit(marker, at + 4);
    at += 2 + *length;
  }
  return false;
}

// In the first directory of the TIFF structure at `base`, which EXIF data are, too.
std::optional<OrientationTag> OrientationOfTiff(const ImageBytes& bytes, std::size_t base) {
  if (!IsTiffAt(bytes, base)) {
    return std::nullopt;
  }
  const bool little_endian = bytes[base] == 'I';
  const auto directory = NumberAt(bytes, base + 4, 4, little_endian);
  if (!directory) {
    return std::nullopt;
  }
  const std::size_t begin = base + *directory;
  const std::size_t count = NumberAt(bytes, begin, 2, little_endian).value_or(0);
  constexpr std::size_t kEntrySize = 12;
  constexpr std::size_t kOrientation = 0x112;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t entry = begin + 2 + i * kEntrySize;
    const auto tag = NumberAt(bytes, entry, 2, little_endian);
    const auto value = NumberAt(bytes, entry + 8, 2, little_endian);
    if (!tag || !value) {
      return std::nullopt;
    }
    if (*tag == kOrientation && *value >= 1 && *value <= 8) {
      return OrientationTag{entry + 8, little_endian, static_cast<int>(*value)};
    }
  }
  return std::nullopt;
}

// Where the EXIF data of a chunk begin: some writers put JPEG's mark before them.
std::size_t AfterExifMark(const ImageBytes& bytes, std::size_t offset) {
  using std::string_view_literals::operator""sv;
  constexpr std::string_view kMark = "Exif\0\0"sv;
  return HasAt(bytes, offset, kMark) ? offset + kMark.size() : offset;
}

std::optional<std::size_t> FindPngExif(const ImageBytes& bytes) {
  for (std::size_t at = 8;;) {
    const auto length = NumberAt(bytes, at, 4, /*little_endian=*/false);
    if (!length) {
      return std::nullopt;
    }
    if (HasAt(bytes, at + 4, "eXIf")) {
      return at + 8;
    }
    at += 12 + *length;
  }
}

std::optional<std::size_t> FindWebpExif(const ImageBytes& bytes) {
  for (std::size_t at = 12;;) {
    const auto length = NumberAt(bytes, at + 4, 4, /*little_endian=*/true);
    if (!length) {
      return std::nullopt;
    }
    if (HasAt(bytes, at, "EXIF")) {
      return at + 8;
    }
    at += 8 + *length + *length % 2;
  }
}

std::optional<std::size_t> FindJpegExif(const ImageBytes& bytes) {
  constexpr unsigned char kApplication1 = 0xE1;
  std::optional<std::size_t> exif;
  WalkJpeg(bytes, [&](unsigned char marker, std::size_t offset) {
    if (!exif && marker == kApplication1 && HasAt(bytes, offset, "Exif")) {
      exif = offset;
    }
  });
  return exif;
}

// The largest value of a PNM file stands third after its mark, behind width and height.
bool PnmHasMoreThanEightBits(const ImageBytes& head) {
  std::string text(head.begin(), head.end());
  int field = -1;
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else if (std::isspace(static_cast<unsigned char>(text[at])) != 0) {
      ++at;
    } else {
      const std::size_t end = std::min(text.find_first_of(" \t\r\n#", at), text.size());
      constexpr int kLargestValue = 2;
      constexpr std::size_t kDigitsOf255 = 3;
      if (field == kLargestValue) {
        const std::string digits = text.substr(at, end - at);
        return digits.size() > kDigitsOf255 || (digits.size() == kDigitsOf255 && digits > "255");
      }
      ++field;
      at = end;
    }
  }
  return false;
}

}  // namespace

bool IsCutOffJpeg(const ImageBytes& bytes) {
  return IsJpeg(bytes) && !WalkJpeg(bytes, [](unsigned char, std::size_t) {});
}

std::optional<OrientationTag> FindOrientation(const ImageBytes& bytes) {
  if (IsTiffAt(bytes, 0)) {
    return OrientationOfTiff(bytes, 0);
  }
  const std::optional<std::size_t> exif = IsJpeg(bytes)   ? FindJpegExif(bytes)
                                          : IsPng(bytes)  ? FindPngExif(bytes)
                                          : IsWebp(bytes) ? FindWebpExif(bytes)
                                                          : std::nullopt;
  return exif ? OrientationOfTiff(bytes, AfterExifMark(bytes, *exif)) : std::nullopt;
}

bool MayHaveMoreThanEightBits(const ImageBytes& head) {
  if (IsPng(head)) {
    constexpr std::size_t kBitDepth = 24;
    return head.size() > kBitDepth && head[kBitDepth] > 8;
  }
  if (!head.empty() && head[0] == 'P') {
    return PnmHasMoreThanEightBits(head);
  }
  using std::string_view_literals::operator""sv;
  return IsTiffAt(head, 0) || HasAt(head, 4, "jP  "sv);
}

}  // namespace gluevo::vo
