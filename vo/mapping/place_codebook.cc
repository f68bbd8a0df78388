#include "gluevo/vo/mapping/place_codebook.h"

#include <algorithm>
#include <utility>

#include "gluevo/nn/error.h"

namespace gluevo::vo {

PlaceCodebook::PlaceCodebook(Centres centres, std::string of_weights)
    : centres_(std::move(centres)), of_weights_(std::move(of_weights)) {
  if (centres_.size() == 0 || !centres_.allFinite()) {
    throw Error("a place codebook of " + std::to_string(centres_.rows()) + " x " +
                std::to_string(centres_.cols()) + " values; expected finite centres, one at least");
  }
  half_squares_ = 0.5F * centres_.rowwise().squaredNorm();
}

PlaceCodebook PlaceCodebook::FromWeights(const nn::Weights& file) {
  const nn::Tensor<float>& tensor = file.Get("centres");
  const nn::Shape& shape = tensor.shape();
  if (shape.rank() != 2) {
    throw Error(file.source + ": tensor \"centres\" has shape " + shape.ToString() +
                ", expected two axes: centres and values");
  }
  const auto of_weights = file.metadata.find("weights");
  return {Eigen::Map<const Centres>(tensor.data(), shape[0], shape[1]),
          of_weights == file.metadata.end() ? "" : of_weights->second};
}

Eigen::VectorXf PlaceCodebook::Describe(const nn::Features& features) const {
  if (features.size() > 0 && features.descriptors.cols() != centres_.cols()) {
    throw Error("descriptors of " + std::to_string(features.descriptors.cols()) +
                " values do not go with a place codebook of " + std::to_string(centres_.cols()));
  }
  Centres sums = Centres::Zero(centres_.rows(), centres_.cols());
  for (int i = 0; i < features.size(); ++i) {
    Eigen::Index nearest = 0;
    (centres_ * features.descriptors.row(i).transpose() - half_squares_).maxCoeff(&nearest);
    sums.row(nearest) += features.descriptors.row(i) - centres_.row(nearest);
  }
  for (Eigen::Index k = 0; k < sums.rows(); ++k) {
    sums.row(k).normalize();  // A row of zeros stays one.
  }
  return Eigen::Map<const Eigen::VectorXf>(sums.data(), sums.size()).normalized();
}

void WritePlaceCodebook(const std::filesystem::path& path, const PlaceCodebook& codebook) {
  const PlaceCodebook::Centres& centres = codebook.centres();
  nn::Weights weights;
  weights.metadata["weights"] = codebook.of_weights();
  nn::Tensor<float> tensor({centres.rows(), centres.cols()});
  std::copy(centres.data(), centres.data() + centres.size(), tensor.data());
  weights.tensors.emplace("centres", std::move(tensor));
  nn::WriteSafetensors(path, weights);
}

}  // namespace gluevo::vo
