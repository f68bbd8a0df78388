#pragma once

#include <string>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/vo/mapping/place_codebook.h"

namespace gluevo::vo {

struct PlaceTrainingOptions {
  int centres = 32;
  int iterations = 30;  ///< At most; fewer where nothing changes any more.

  /// Throws Error naming the option.
  void Validate() const;
};

/// A codebook from images' descriptors: Lloyd's k-means, started from descriptors drawn with a
/// fixed seed. The same input gives the same result. Throws Error for fewer descriptors than
/// centres, or of different widths.
PlaceCodebook TrainPlaceCodebook(const std::vector<nn::Features>& images,
                                 const std::string& of_weights,
                                 const PlaceTrainingOptions& options);

}  // namespace gluevo::vo
