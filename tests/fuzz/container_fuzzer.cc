#include <cstddef>
#include <cstdint>

#include "containers.h"
#include "dialects.h"
#include "gluevo/nn/error.h"
#include "gluevo/weights_tools/architecture.h"

// Everything that a conversion does, of a file of any form.

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  try {
    for (const auto& network : weights_tools::ToCanonical(
             weights_tools::ParseContainer(data, size, "file"), weights_tools::kPublishedHeads)) {
      weights_tools::ReadArchitecture(network.weights);
    }
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
