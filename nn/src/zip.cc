#include "gluevo/nn/zip.h"

#define ZLIB_CONST  // zlib then takes its input as constant.
#include <zlib.h>

#include <algorithm>
#include <set>
#include <utility>

#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

constexpr uint32_t kLocalSignature = 0x04034b50;
constexpr uint32_t kCentralSignature = 0x02014b50;
constexpr uint32_t kEndSignature = 0x06054b50;
constexpr uint64_t kLocalSize = 30;
constexpr uint64_t kCentralSize = 46;
constexpr uint64_t kEndSize = 22;
constexpr uint32_t kEnd64Signature = 0x06064b50;
constexpr uint64_t kEnd64Size = 56;
constexpr uint32_t kLocator64Signature = 0x07064b50;
constexpr uint64_t kLocator64Size = 20;
constexpr uint32_t kZip64Mark = 0xffffffff;
constexpr uint16_t kEncrypted = 1U << 0;
constexpr uint16_t kDescriptorFollows = 1U << 3;
// Signature, CRC and two sizes of eight bytes: the longest data descriptor.
constexpr uint64_t kLongestDescriptor = 24;

// Deflate turns one bit into at most 129 bytes (zlib's technical details: 1032 to 1), which zeros
// come close to. A whole archive of weights does not: it may be small, or else not inflate a
// hundredfold.
constexpr uint64_t kDeflateLimit = 1032;
constexpr uint64_t kFreeSize = uint64_t{64} << 20;
constexpr uint64_t kArchiveLimit = 100;

uint64_t FindEnd(const Bytes& file) {
  // A comment of up to 65535 bytes may follow the end record.
  const uint64_t last = file.size() < kEndSize ? 0 : file.size() - kEndSize;
  const uint64_t first = last > 0xffff ? last - 0xffff : 0;
  if (file.size() >= kEndSize) {
    for (uint64_t at = last + 1; at-- > first;) {
      if (file.U32(at, "the archive") == kEndSignature &&
          file.U16(at + 20, "the archive") == last - at) {
        return at;
      }
    }
  }
  file.Fail(file.size(),
            "the zip archive has no end record here: it is cut short or has trailing bytes");
}

struct Directory {
  uint64_t count = 0;
  uint64_t at = 0;
  uint64_t end = 0;
};

// The end record's numbers, or those of the zip64 end record before it: PyTorch writes one always.
Directory FindDirectory(const Bytes& file) {
  const uint64_t end = FindEnd(file);
  const Bytes record = file.Slice(end, kEndSize, "the end record");
  const uint16_t count = record.U16(10, "the end record");
  const uint32_t size = record.U32(12, "the end record");
  const uint32_t at = record.U32(16, "the end record");
  if (record.U16(4, "") != 0 || record.U16(6, "") != 0 || record.U16(8, "") != count) {
    file.Fail(end, "the zip archive is spread over several disks");
  }
  const auto refuse = [&file](uint64_t place, uint64_t directory_size, uint64_t directory_at) {
    file.Fail(place, "the central directory is said to be " + std::to_string(directory_size) +
                         " bytes at byte " + std::to_string(directory_at) +
                         ", expected it to end here");
  };
  if (end < kLocator64Size + kEnd64Size ||
      file.U32(end - kLocator64Size, "") != kLocator64Signature) {
    if (count == 0xffff || size == kZip64Mark || at == kZip64Mark) {
      file.Fail(end, "the zip archive is in the zip64 form but has no zip64 end record");
    }
    if (uint64_t{at} + size != end) {
      refuse(end, size, at);
    }
    return {count, at, end};
  }

  const uint64_t end64 = end - kLocator64Size - kEnd64Size;
  const std::string what = "the zip64 end record";
  const Bytes locator = file.Slice(end - kLocator64Size, kLocator64Size, what);
  const Bytes record64 = file.Slice(end64, kEnd64Size, what);
  if (locator.U32(4, what) != 0 || locator.U64(8, what) != end64 || locator.U32(16, what) != 1 ||
      record64.U32(0, what) != kEnd64Signature || record64.U64(4, what) != kEnd64Size - 12 ||
      record64.U32(16, what) != 0 || record64.U32(20, what) != 0) {
    file.Fail(end64, what + " is not here as its locator says");
  }
  const uint64_t count64 = record64.U64(32, what);
  const uint64_t size64 = record64.U64(40, what);
  const uint64_t at64 = record64.U64(48, what);
  if (record64.U64(24, what) != count64 || (count != 0xffff && count != count64) ||
      (size != kZip64Mark && size != size64) || (at != kZip64Mark && at != at64)) {
    file.Fail(end64, what + " contradicts the end record");
  }
  if (size64 > end64 || at64 != end64 - size64) {
    refuse(end64, size64, at64);
  }
  return {count64, at64, end64};
}

// Nothing is ever written under these names; an archive with such ones was not made for weights.
void CheckName(const Bytes& file, uint64_t at, const std::string& name) {
  const std::string padded = "/" + name + "/";
  if (name.empty() || name.starts_with('/') || name.find('\\') != std::string::npos ||
      name.find('\0') != std::string::npos || padded.find("/../") != std::string::npos) {
    file.Fail(at, "the name " + Quoted(name) + " leads out of the archive");
  }
}

// Where the data of an entry begin, after its local header; the header must agree with the entry.
uint64_t CheckLocalHeader(const Bytes& file, const ZipEntry& entry, uint16_t flags,
                          uint16_t method) {
  const std::string what = "the local header of " + Quoted(entry.name);
  if (file.U32(entry.at, what) != kLocalSignature) {
    file.Fail(entry.at, what + " is not here");
  }
  const Bytes header = file.Slice(entry.at, kLocalSize, what);
  const uint16_t name_size = header.U16(26, what);
  const Bytes name = file.Slice(entry.at + kLocalSize, name_size, what);
  const std::string local_name(reinterpret_cast<const char*>(name.data()), name_size);
  if (local_name != entry.name) {
    file.Fail(entry.at, what + " names it " + Quoted(local_name));
  }
  if (header.U16(6, what) != flags || header.U16(8, what) != method) {
    file.Fail(entry.at, what + " has other flags or another method than the central directory");
  }
  if ((flags & kDescriptorFollows) == 0) {
    // numpy writes the zip64 mark here even for small arrays.
    const uint32_t packed = header.U32(18, what);
    const uint32_t size = header.U32(22, what);
    if (header.U32(14, what) != entry.crc ||
        (packed != kZip64Mark && packed != entry.stored.size()) ||
        (size != kZip64Mark && size != entry.size)) {
      file.Fail(entry.at, what + " has another CRC or size than the central directory");
    }
  }
  return entry.at + kLocalSize + name_size + header.U16(28, what);
}

void CheckBombs(const Bytes& file, const std::vector<ZipEntry>& entries) {
  uint64_t total = 0;
  for (const ZipEntry& entry : entries) {
    total += entry.size;
    if (entry.size > kDeflateLimit * entry.stored.size() + kDeflateLimit) {
      file.Fail(entry.at, "entry " + Quoted(entry.name) + " claims to inflate from " +
                              std::to_string(entry.stored.size()) + " to " +
                              std::to_string(entry.size) + " bytes, which deflate cannot reach");
    }
    if (total > kFreeSize + kArchiveLimit * file.size()) {
      file.Fail(entry.at, "with entry " + Quoted(entry.name) + " the archive inflates to " +
                              std::to_string(total) + " bytes, more than " +
                              std::to_string(kArchiveLimit) + " times its size");
    }
  }
}

// An entry, and which bytes of the archive are its own.
struct Placed {
  ZipEntry entry;
  uint64_t data_end = 0;
  uint64_t slack = 0;         // A data descriptor of at most so many bytes may follow.
  uint64_t next_central = 0;  // Where the central directory's next entry is.
};

// The central directory's entry at `at`, with its local header; `what` names it in messages.
Placed ReadEntry(const Bytes& file, const Directory& directory, uint64_t at,
                 const std::string& what) {
  const Bytes central = file.Slice(at, kCentralSize, what);
  if (at + kCentralSize > directory.end || central.U32(0, what) != kCentralSignature) {
    file.Fail(at, what + " is not here");
  }
  const uint16_t name_size = central.U16(28, what);
  const uint64_t next =
      at + kCentralSize + name_size + central.U16(30, what) + central.U16(32, what);
  if (next > directory.end) {
    file.Fail(at, what + " reaches beyond the directory");
  }
  const std::string name(
      reinterpret_cast<const char*>(file.Slice(at + kCentralSize, name_size, what).data()),
      name_size);
  const uint16_t flags = central.U16(8, what);
  const uint16_t method = central.U16(10, what);
  const uint32_t packed = central.U32(20, what);
  const uint32_t size = central.U32(24, what);
  const auto refuse = [&](const std::string& why) {
    file.Fail(at, "entry " + Quoted(name) + " " + why);
  };
  CheckName(file, at, name);
  if ((flags & kEncrypted) != 0) {
    refuse("is encrypted");
  }
  if (method != 0 && method != Z_DEFLATED) {
    refuse("is compressed by method " + std::to_string(method) +
           ", expected 0 (stored) or 8 (deflate)");
  }
  if (packed == kZip64Mark || size == kZip64Mark || central.U32(42, what) == kZip64Mark) {
    refuse("is in the zip64 form, expected one below 4 GB");
  }
  if (method == 0 && packed != size) {
    refuse("is stored but its two sizes differ: " + std::to_string(packed) + " and " +
           std::to_string(size));
  }
  ZipEntry entry{.name = name,
                 .at = central.U32(42, what),
                 .stored = file.Slice(0, 0, what),
                 .deflated = method != 0,
                 .size = size,
                 .crc = central.U32(16, what)};
  if (entry.at >= directory.at) {
    refuse("is said to be at byte " + std::to_string(entry.at) +
           ", within or after the central directory");
  }
  // Checked for its bounds first, as the local header is compared with its size.
  entry.stored = file.Slice(entry.at, packed, "entry " + Quoted(name));
  const uint64_t data = CheckLocalHeader(file, entry, flags, method);
  entry.stored = file.Slice(data, packed, "entry " + Quoted(name));
  return {entry, data + packed,
          (flags & kDescriptorFollows) != 0 ? kLongestDescriptor : uint64_t{0}, next};
}

// Every byte before the central directory belongs to one entry.
void CheckCoverage(const Bytes& file, uint64_t directory_at, std::vector<Placed> placed) {
  std::sort(placed.begin(), placed.end(),
            [](const Placed& a, const Placed& b) { return a.entry.at < b.entry.at; });
  uint64_t covered = 0;
  uint64_t slack = 0;
  for (const Placed& item : placed) {
    if (item.entry.at < covered) {
      file.Fail(item.entry.at, "entry " + Quoted(item.entry.name) + " overlaps another");
    }
    if (item.entry.at - covered > slack) {
      file.Fail(covered, std::to_string(item.entry.at - covered) + " bytes before entry " +
                             Quoted(item.entry.name) + " belong to no entry");
    }
    covered = item.data_end;
    slack = item.slack;
  }
  if (covered > directory_at) {
    file.Fail(directory_at, "the last entry overlaps the central directory");
  }
  if (directory_at - covered > slack) {
    file.Fail(covered, std::to_string(directory_at - covered) +
                           " bytes before the central directory belong to no entry");
  }
}

}  // namespace

std::vector<ZipEntry> ReadZipDirectory(const Bytes& file) {
  const Directory directory = FindDirectory(file);
  std::vector<Placed> placed;
  std::vector<ZipEntry> entries;
  std::set<std::string> names;
  uint64_t at = directory.at;
  for (uint64_t i = 0; i < directory.count; ++i) {
    placed.push_back(
        ReadEntry(file, directory, at, "entry " + std::to_string(i) + " of the central directory"));
    const Placed& item = placed.back();
    if (!names.insert(item.entry.name).second) {
      file.Fail(at, "the name " + Quoted(item.entry.name) + " comes twice");
    }
    entries.push_back(item.entry);
    at = item.next_central;
  }
  if (at != directory.end) {
    file.Fail(at, std::to_string(directory.end - at) +
                      " bytes of the central directory belong to no entry");
  }
  CheckCoverage(file, directory.at, std::move(placed));
  CheckBombs(file, entries);
  return entries;
}

}  // namespace gluevo::nn
