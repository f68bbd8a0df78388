#include "gluevo/nn/nearest_neighbor.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"

namespace gluevo::nn {

void NearestNeighborOptions::Validate() const {
  if (!(max_ratio > 0.0F && max_ratio <= 1.0F)) {
    throw OptionError("nearest-neighbour ratio " + std::to_string(max_ratio) +
                      " is out of range: expected above 0 and at most 1");
  }
  if (!(min_similarity >= -1.0F && min_similarity <= 1.0F)) {
    throw OptionError("nearest-neighbour similarity " + std::to_string(min_similarity) +
                      " is out of range: expected -1 to 1");
  }
}

Matches MatchNearestNeighbors(const Features& features0, const Features& features1,
                              const NearestNeighborOptions& options) {
  options.Validate();
  const auto n0 = static_cast<Eigen::Index>(features0.size());
  const auto n1 = static_cast<Eigen::Index>(features1.size());
  Matches matches;
  matches.matches0.assign(static_cast<std::size_t>(n0), -1);
  matches.scores0.assign(static_cast<std::size_t>(n0), 0.0F);
  if (n0 == 0 || n1 == 0) {
    return matches;
  }
  if (features0.descriptors.cols() != features1.descriptors.cols()) {
    throw Error("descriptors of " + std::to_string(features0.descriptors.cols()) + " and of " +
                std::to_string(features1.descriptors.cols()) + " values cannot be matched");
  }
  const Features::RowMajor similarity = features0.descriptors * features1.descriptors.transpose();
  Eigen::VectorX<Eigen::Index> best0(n1);  // Of image 1's keypoints.
  for (Eigen::Index j = 0; j < n1; ++j) {
    similarity.col(j).maxCoeff(&best0[j]);
  }
  for (Eigen::Index i = 0; i < n0; ++i) {
    Eigen::Index best = 0;
    const float cosine = similarity.row(i).maxCoeff(&best);
    float second = -1.0F;
    for (Eigen::Index j = 0; j < n1; ++j) {
      second = j != best ? std::max(second, similarity(i, j)) : second;
    }
    // |a - b|^2 = 2 - 2 cos for unit vectors.
    const float ratio = std::sqrt(std::max(0.0F, 1.0F - cosine) / std::max(1e-12F, 1.0F - second));
    if ((options.mutual && best0[best] != i) || cosine < options.min_similarity ||
        (options.max_ratio < 1.0F && ratio >= options.max_ratio)) {
      continue;
    }
    matches.matches0[static_cast<std::size_t>(i)] = static_cast<int>(best);
    matches.scores0[static_cast<std::size_t>(i)] = std::clamp(cosine, 0.0F, 1.0F);
  }
  return matches;
}

}  // namespace gluevo::nn
