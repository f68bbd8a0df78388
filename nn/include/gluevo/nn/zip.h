#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gluevo/nn/bytes.h"

namespace gluevo::nn {

/// One file in a zip archive.
struct ZipEntry {
  std::string name;
  uint64_t at = 0;  ///< Offset in the archive of its local header.
  Bytes stored;     ///< As it lies in the archive.
  bool deflated = false;
  uint64_t size = 0;  ///< Inflated size in bytes.
  uint32_t crc = 0;   ///< CRC-32 of the inflated bytes.
};

/// The entries of a zip archive as its central directory lists them (PKWARE's APPNOTE, without
/// encryption and several disks; with zip64's end record, but entries below 4 GB). Throws Error
/// with the offset for anything out of bounds or that contradicts itself: entries that overlap,
/// bytes that belong to none, names that come twice or lead out of the archive, local headers that
/// differ, sizes that deflate cannot reach or that together are a bomb.
std::vector<ZipEntry> ReadZipDirectory(const Bytes& file);

/// The bytes of one entry, inflated where they have to be.
class ZipData {
 public:
  /// Throws Error with the offset where the stream is broken, is not exactly of the size that the
  /// directory gives, or fails its CRC.
  explicit ZipData(const ZipEntry& entry);
  const Bytes& bytes() const { return bytes_; }

 private:
  std::unique_ptr<unsigned char[]> inflated_;
  Bytes bytes_;
};

}  // namespace gluevo::nn
