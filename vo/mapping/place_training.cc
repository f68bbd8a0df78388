#include "gluevo/vo/mapping/place_training.h"

#include <random>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/options_check.h"

namespace gluevo::vo {
namespace {

using Rows = PlaceCodebook::Centres;

Rows AllDescriptors(const std::vector<nn::Features>& images) {
  Eigen::Index count = 0;
  Eigen::Index width = 0;
  for (const nn::Features& image : images) {
    if (image.size() > 0 && width > 0 && image.descriptors.cols() != width) {
      throw Error("descriptors of " + std::to_string(width) + " and of " +
                  std::to_string(image.descriptors.cols()) + " values make no codebook together");
    }
    count += image.size();
    width = image.size() > 0 ? image.descriptors.cols() : width;
  }
  Rows all(count, width);
  Eigen::Index row = 0;
  for (const nn::Features& image : images) {
    if (image.size() > 0) {
      all.middleRows(row, image.size()) = image.descriptors;
      row += image.size();
    }
  }
  return all;
}

Rows DrawnRows(const Rows& all, int count) {
  std::mt19937_64 generator(0);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(all.rows()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = static_cast<Eigen::Index>(i);
  }
  for (int i = 0; i < count; ++i) {
    std::swap(order[i], order[i + generator() % (order.size() - static_cast<std::size_t>(i))]);
  }
  order.resize(static_cast<std::size_t>(count));
  return all(order, Eigen::all);
}

// The nearest centre of each row.
std::vector<Eigen::Index> Assign(const Rows& all, const Rows& centres) {
  const Eigen::VectorXf half_squares = 0.5F * centres.rowwise().squaredNorm();
  std::vector<Eigen::Index> nearest(static_cast<std::size_t>(all.rows()));
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    (centres * all.row(i).transpose() - half_squares).maxCoeff(&nearest[i]);
  }
  return nearest;
}

// A centre that nothing is near to stays where it is.
Rows Means(const Rows& all, const std::vector<Eigen::Index>& nearest, const Rows& centres) {
  Rows means = Rows::Zero(centres.rows(), centres.cols());
  Eigen::VectorXf counts = Eigen::VectorXf::Zero(centres.rows());
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    means.row(nearest[i]) += all.row(i);
    counts(nearest[i]) += 1.0F;
  }
  for (Eigen::Index k = 0; k < centres.rows(); ++k) {
    if (counts(k) > 0.0F) {
      means.row(k) /= counts(k);
    } else {
      means.row(k) = centres.row(k);
    }
  }
  return means;
}

}  // namespace

void PlaceTrainingOptions::Validate() const {
  CheckAtLeast(centres, 1, "centres (--centres)");
  CheckAtLeast(iterations, 1, "iterations");
}

PlaceCodebook TrainPlaceCodebook(const std::vector<nn::Features>& images,
                                 const std::string& of_weights,
                                 const PlaceTrainingOptions& options) {
  options.Validate();
  const Rows all = AllDescriptors(images);
  if (all.rows() < options.centres) {
    throw Error(std::to_string(all.rows()) + " descriptors make no codebook of " +
                std::to_string(options.centres) + " centres; expected more images");
  }
  Rows centres = DrawnRows(all, options.centres);
  std::vector<Eigen::Index> nearest = Assign(all, centres);
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    centres = Means(all, nearest, centres);
    std::vector<Eigen::Index> next = Assign(all, centres);
    if (next == nearest) {
      break;
    }
    nearest = std::move(next);
  }
  return {std::move(centres), of_weights};
}

}  // namespace gluevo::vo
