#include <cstddef>
#include <cstdint>

#include "gluevo/nn/error.h"
#include "torch.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  try {
    nn::Weights weights;
    weights_tools::ParseTorchLegacy(nn::Bytes(data, size, "file"), weights);
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
