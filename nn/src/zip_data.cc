#define ZLIB_CONST  // zlib then takes its input as constant.
#include <zlib.h>

#include "gluevo/nn/error.h"
#include "gluevo/nn/zip.h"

namespace gluevo::nn {
namespace {

std::unique_ptr<unsigned char[]> Inflate(const ZipEntry& entry) {
  const std::string subject = "entry " + Quoted(entry.name);
  // One byte more than wanted, so that a stream that goes on is noticed.
  auto inflated = std::make_unique<unsigned char[]>(entry.size + 1);
  z_stream stream = {};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) {
    throw Error("zlib cannot be started");
  }
  stream.next_in = entry.stored.data();
  stream.avail_in = static_cast<uInt>(entry.stored.size());
  stream.next_out = inflated.get();
  stream.avail_out = static_cast<uInt>(entry.size + 1);
  const int result = inflate(&stream, Z_FINISH);
  const uint64_t consumed = entry.stored.size() - stream.avail_in;
  const uint64_t produced = stream.total_out;
  inflateEnd(&stream);
  if (produced > entry.size) {
    entry.stored.Fail(consumed, subject + " inflates to more than the " +
                                    std::to_string(entry.size) + " bytes of its header");
  }
  if (result != Z_STREAM_END) {
    entry.stored.Fail(consumed, subject + " is not a whole deflate stream");
  }
  if (produced != entry.size) {
    entry.stored.Fail(consumed, subject + " inflates to " + std::to_string(produced) +
                                    " bytes, expected " + std::to_string(entry.size));
  }
  if (consumed != entry.stored.size()) {
    entry.stored.Fail(consumed, subject + " has " + std::to_string(entry.stored.size() - consumed) +
                                    " trailing bytes after its deflate stream");
  }
  return inflated;
}

}  // namespace

ZipData::ZipData(const ZipEntry& entry)
    : inflated_(entry.deflated ? Inflate(entry) : nullptr),
      bytes_(entry.deflated ? entry.stored.Inflated(inflated_.get(), entry.size) : entry.stored) {
  const uLong crc = crc32_z(crc32(0, nullptr, 0), bytes_.data(), bytes_.size());
  if (crc != entry.crc) {
    entry.stored.Fail(0, "entry " + Quoted(entry.name) + " fails its CRC: the file is damaged");
  }
}

}  // namespace gluevo::nn
