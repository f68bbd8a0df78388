#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "weight_files.h"

// Zip archives put together byte by byte, with every field open to lies.

namespace gluevo::nn {

// CRC-32 as its definition has it, bit by bit (reflected polynomial 0xedb88320).
inline uint32_t Crc(const std::string& bytes) {
  uint32_t crc = ~uint32_t{0};
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320U : 0U);
    }
  }
  return ~crc;
}

// A deflate stream of one stored block (RFC 1951, 3.2.4).
inline std::string StoredBlock(const std::string& data) {
  const auto size = static_cast<uint16_t>(data.size());
  return '\1' + Le(size) + Le(static_cast<uint16_t>(~size)) + data;
}

/// One entry, with every field open to lies.
struct Entry {
  Entry(const std::string& name_, const std::string& content)
      : name(name_),
        local_name(name_),
        packed(content),
        crc(Crc(content)),
        packed_size(static_cast<uint32_t>(content.size())),
        size(packed_size) {}

  static Entry Deflated(const std::string& name, const std::string& content,
                        const std::string& packed) {
    Entry entry(name, content);
    entry.method = 8;
    entry.packed = packed;
    entry.packed_size = static_cast<uint32_t>(packed.size());
    return entry;
  }

  std::string name;
  std::string local_name;
  std::string packed;
  uint32_t crc;
  uint32_t packed_size;
  uint32_t size;
  uint16_t method = 0;
  uint16_t flags = 0;
  int64_t local_at = -1;  // Where the directory says it is; -1 for where it is.
  std::string extra;      // Of the local header.
  std::string after;      // Bytes between this entry and what follows.
  bool zip64_mark = false;
};

struct Archive {
  std::vector<Entry> entries;
  std::string before = {};
  std::string comment = {};
  std::string after_directory = {};
  int count_off = 0;
  int directory_off = 0;
  /// With a zip64 end record and its locator, as PyTorch writes them.
  bool end64 = false;
  int end64_off = 0;  // Added to what the zip64 record says of the directory's place.

  std::string Bytes() const {
    std::string file = before;
    std::string directory;
    std::string after_directory_and_64 = after_directory;
    for (const Entry& entry : entries) {
      const uint32_t at = entry.local_at >= 0 ? static_cast<uint32_t>(entry.local_at)
                                              : static_cast<uint32_t>(file.size());
      const bool descriptor = (entry.flags & 8) != 0;
      const std::string sizes = descriptor ? Le<uint32_t>(0) + Le<uint32_t>(0) + Le<uint32_t>(0)
                                : entry.zip64_mark
                                    ? Le(entry.crc) + Le(0xffffffffU) + Le(0xffffffffU)
                                    : Le(entry.crc) + Le(entry.packed_size) + Le(entry.size);
      file += "PK\3\4" + Le<uint16_t>(20) + Le(entry.flags) + Le(entry.method) + Le<uint32_t>(0) +
              sizes + Le(static_cast<uint16_t>(entry.local_name.size())) +
              Le(static_cast<uint16_t>(entry.extra.size())) + entry.local_name + entry.extra +
              entry.packed + entry.after;
      directory += "PK\1\2" + Le<uint16_t>(20) + Le<uint16_t>(20) + Le(entry.flags) +
                   Le(entry.method) + Le<uint32_t>(0) + Le(entry.crc) + Le(entry.packed_size) +
                   Le(entry.size) + Le(static_cast<uint16_t>(entry.name.size())) + Le<uint16_t>(0) +
                   Le<uint16_t>(0) + Le<uint16_t>(0) + Le<uint16_t>(0) + Le<uint32_t>(0) + Le(at) +
                   entry.name;
    }
    const auto count = static_cast<uint16_t>(static_cast<int>(entries.size()) + count_off);
    const auto directory_at = static_cast<uint32_t>(static_cast<int>(file.size()) + directory_off);
    if (end64) {
      const auto size = static_cast<uint64_t>(directory.size() + after_directory.size());
      const uint64_t end64_at = file.size() + size;
      after_directory_and_64 =
          after_directory + "PK\6\6" + Le<uint64_t>(44) + Le<uint16_t>(0x031e) + Le<uint16_t>(45) +
          Le<uint32_t>(0) + Le<uint32_t>(0) + Le<uint64_t>(count) + Le<uint64_t>(count) + Le(size) +
          Le(uint64_t{directory_at} + static_cast<uint64_t>(end64_off)) + "PK\6\7" +
          Le<uint32_t>(0) + Le(end64_at) + Le<uint32_t>(1);
    }
    return file + directory + after_directory_and_64 + "PK\5\6" + Le<uint32_t>(0) + Le(count) +
           Le(count) + Le(static_cast<uint32_t>(directory.size() + after_directory.size())) +
           Le(directory_at) + Le(static_cast<uint16_t>(comment.size())) + comment;
  }
};

}  // namespace gluevo::nn
