#pragma once

#include "gluevo/nn/features.h"

namespace gluevo::nn {

struct NearestNeighborOptions {
  /// Only pairs that are each other's nearest.
  bool mutual = true;
  /// Lowe's ratio (2004): the nearest must be closer than this times the second nearest; 1 accepts
  /// all.
  float max_ratio = 1.0F;
  /// Smallest cosine of the two descriptors, -1 to 1.
  float min_similarity = -1.0F;

  /// Throws Error naming the field that is out of range.
  void Validate() const;
};

/// Matches by descriptor alone; a match's confidence is the cosine, clamped to 0 to 1. Throws Error
/// where the two sets' descriptors differ in size.
Matches MatchNearestNeighbors(const Features& features0, const Features& features1,
                              const NearestNeighborOptions& options);

}  // namespace gluevo::nn
