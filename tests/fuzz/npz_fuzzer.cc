#include <cstddef>
#include <cstdint>

#include "gluevo/nn/error.h"
#include "gluevo/nn/zip.h"

// The zip archive by itself: its CRCs keep changed arrays from the reader of .npy.

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  try {
    for (const nn::ZipEntry& entry : nn::ReadZipDirectory(nn::Bytes(data, size, "file"))) {
      try {
        const nn::ZipData inflated(entry);
      } catch (const Error&) {
      }
    }
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
