#include <cstddef>
#include <cstdint>

#include "gluevo/nn/error.h"
#include "pickle.h"
#include "state_dict.h"

// The pickle of an archive, whose CRC keeps changed ones from the reader; every storage is the
// input itself.

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  try {
    const nn::Bytes bytes(data, size, "file");
    const weights_tools::Pickle pickle = weights_tools::ReadPickle(bytes);
    nn::Weights weights;
    weights_tools::ReadStateDict(
        pickle, bytes, [&](const weights_tools::PickleObject&) { return bytes; }, size, weights);
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
