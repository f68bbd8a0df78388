#include <cstddef>
#include <cstdint>

#include "gluevo/nn/error.h"
#include "onnx.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  try {
    weights_tools::Container container;
    weights_tools::ParseOnnx(nn::Bytes(data, size, "file"), container);
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
