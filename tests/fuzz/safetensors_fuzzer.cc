#include <cstddef>
#include <cstdint>

#include "gluevo/nn/error.h"
#include "gluevo/nn/weights.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  try {
    nn::ParseWeights(data, size, "file");
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
