#include "gluevo/nn/weights.h"

// Defined in open_weights.S.
extern "C" {
extern const unsigned char gluevo_open_superpoint_begin[];  // NOLINT(readability-identifier-naming)
extern const unsigned char gluevo_open_superpoint_end[];    // NOLINT(readability-identifier-naming)
extern const unsigned char gluevo_open_superglue_begin[];   // NOLINT(readability-identifier-naming)
extern const unsigned char gluevo_open_superglue_end[];     // NOLINT(readability-identifier-naming)
extern const unsigned char gluevo_open_places_begin[];      // NOLINT(readability-identifier-naming)
extern const unsigned char gluevo_open_places_end[];        // NOLINT(readability-identifier-naming)
}

namespace gluevo::nn {

Weights OpenSuperPointWeights() {
  return ParseWeights(
      gluevo_open_superpoint_begin,
      static_cast<std::size_t>(gluevo_open_superpoint_end - gluevo_open_superpoint_begin),
      "built-in superpoint");
}

Weights OpenSuperGlueWeights() {
  return ParseWeights(
      gluevo_open_superglue_begin,
      static_cast<std::size_t>(gluevo_open_superglue_end - gluevo_open_superglue_begin),
      "built-in superglue");
}

Weights OpenPlaceCodebook() {
  return ParseWeights(gluevo_open_places_begin,
                      static_cast<std::size_t>(gluevo_open_places_end - gluevo_open_places_begin),
                      "built-in place codebook");
}

}  // namespace gluevo::nn
