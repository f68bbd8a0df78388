#include <cstddef>
#include <cstdint>

#include "aliked_weights.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/weights.h"
#include "lightglue_weights.h"

// What the runtime reads of ALIKED's and LightGlue's weights, of a file in its own form.

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  const auto read = [&](const auto& of) {
    try {
      of(nn::ParseWeights(data, size, "file"));
    } catch (const Error&) {  // The one answer that a broken file may get.
    }
  };
  read(nn::ReadAlikedWeights);
  read(nn::ReadLightGlueWeights);
  return 0;
}
