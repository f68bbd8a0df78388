#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "gluevo/nn/features.h"
#include "gluevo/nn/weights.h"

namespace gluevo::vo {

/// Typical descriptors of one network, by which whole images are described (VLAD: Jegou et al.
/// 2010, with the normalisation within each centre of Arandjelovic and Zisserman 2013).
class PlaceCodebook {
 public:
  using Centres = nn::Features::RowMajor;

  /// `centres`: K x D, descriptors' means; `of_weights`: SHA-256 of the weights whose descriptors
  /// they are, empty where that is not known. Throws Error for none, and for values that are not
  /// finite.
  PlaceCodebook(Centres centres, std::string of_weights);

  /// From a file as WritePlaceCodebook writes it. Throws Error naming the file and what is wrong
  /// with it.
  static PlaceCodebook FromWeights(const nn::Weights& file);

  int descriptor_size() const { return static_cast<int>(centres_.cols()); }
  const std::string& of_weights() const { return of_weights_; }
  const Centres& centres() const { return centres_; }

  /// The image's place descriptor, K D values of unit length (all 0 for no keypoints): sums of the
  /// differences to the nearest centre, each centre's of unit length before all are. Throws Error
  /// where the descriptors have another width.
  Eigen::VectorXf Describe(const nn::Features& features) const;

 private:
  Centres centres_;
  Eigen::VectorXf half_squares_;  // Of the centres' lengths.
  std::string of_weights_;
};

/// Writes a safetensors file: tensor "centres" [K x D], metadata "weights" (the checksum). Throws
/// Error where it cannot be written.
void WritePlaceCodebook(const std::filesystem::path& path, const PlaceCodebook& codebook);

}  // namespace gluevo::vo
