#include "gluevo/nn/byte_vectors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "gluevo/nn/error.h"
#include "kernels/kernels.h"

namespace gluevo::nn {
namespace {

constexpr int kLargestByte = 127;
// Steps of the fine byte in one of the coarse one: half of these on either side.
constexpr int kFineSteps = 2 * kLargestByte;
constexpr float kFloatUnit = 0x1p-24F;

double NearestByte(double steps) {
  return std::clamp<double>(std::round(steps), -kLargestByte, kLargestByte);
}

ByteVectors::Bounds Around(double product, double error) {
  return {static_cast<float>(product - error), static_cast<float>(product + error)};
}

}  // namespace

ByteVectors::ByteVectors(Isa isa) : kernels_(&kernels::KernelsFor(isa)) {}

ByteVectors::Rounded ByteVectors::Round(const Eigen::VectorXf& vector) const {
  if ((size() > 0 && vector.size() != values_) || vector.size() > kernels::kMaxBytes) {
    throw Error(
        "a vector of " + std::to_string(vector.size()) + " values; expected " +
        (size() > 0 ? std::to_string(values_) : "at most " + std::to_string(kernels::kMaxBytes)));
  }
  if (!vector.allFinite()) {
    throw Error("a vector with values that are not finite");
  }
  Rounded rounded;
  const auto bytes = static_cast<std::size_t>((vector.size() + kernels::kByteBlock - 1) /
                                              kernels::kByteBlock * kernels::kByteBlock);
  rounded.coarse.assign(bytes, 0);
  rounded.fine.assign(bytes, 0);
  rounded.scale = vector.size() > 0 ? vector.cwiseAbs().maxCoeff() / kLargestByte : 0.0F;
  const double scale = rounded.scale;
  double square = 0.0;
  double fine_square = 0.0;
  double error_square = 0.0;
  for (Eigen::Index i = 0; i < vector.size(); ++i) {
    const double value = vector[i];
    const double coarse = scale > 0.0 ? NearestByte(value / scale) : 0.0;
    const double rest = value - scale * coarse;
    const double fine = scale > 0.0 ? NearestByte(kFineSteps * rest / scale) : 0.0;
    const double error = rest - scale * fine / kFineSteps;
    rounded.coarse[static_cast<std::size_t>(i)] = static_cast<int8_t>(coarse);
    rounded.fine[static_cast<std::size_t>(i)] = static_cast<int8_t>(fine);
    square += value * value;
    fine_square += rest * rest;
    error_square += error * error;
  }
  rounded.length = static_cast<float>(std::sqrt(square));
  rounded.fine_length = static_cast<float>(std::sqrt(fine_square));
  rounded.error = static_cast<float>(std::sqrt(error_square));
  // Higham 2002, section 3.1; and a few more for the roundings here.
  rounded.product_loss = kFloatUnit * static_cast<float>(vector.size() + 8);
  return rounded;
}

void ByteVectors::Add(const Eigen::VectorXf& vector) {
  const Rounded rounded = Round(vector);
  values_ = vector.size();
  coarse_.insert(coarse_.end(), rounded.coarse.begin(), rounded.coarse.end());
  fine_.insert(fine_.end(), rounded.fine.begin(), rounded.fine.end());
  vectors_.push_back({rounded.scale, rounded.length, rounded.fine_length, rounded.error});
}

void ByteVectors::Multiply(const std::vector<int8_t>& a, const std::vector<int8_t>& b,
                           std::size_t first, std::size_t count, int32_t* out) const {
  kernels_->byte_products({.a = a.data(),
                           .b = b.data() + first * a.size(),
                           .size = static_cast<int64_t>(a.size()),
                           .rows = static_cast<int64_t>(count),
                           .out = out});
}

// The vector is c + f + e: coarse, fine, what both leave out; that of the index C + F + E. What is
// not multiplied is bounded by its lengths (Cauchy and Schwarz).
std::vector<ByteVectors::Bounds> ByteVectors::Products(const Rounded& vector,
                                                       std::size_t count) const {
  constexpr std::size_t kRows = 8;  // Still in the cache when the fine bytes come to them.
  std::vector<Bounds> bounds(count);
  for (std::size_t first = 0; first < count; first += kRows) {
    const std::size_t rows = std::min(kRows, count - first);
    std::array<int32_t, kRows> coarse{};
    std::array<int32_t, kRows> fine{};
    Multiply(vector.coarse, coarse_, first, rows, coarse.data());
    Multiply(vector.fine, coarse_, first, rows, fine.data());
    for (std::size_t k = 0; k < rows; ++k) {
      const Stored& other = vectors_[first + k];
      const double product = static_cast<double>(vector.scale) * other.scale *
                             (coarse[k] + static_cast<double>(fine[k]) / kFineSteps);
      // (c + f + e) (F + E), and e C.
      const double error = static_cast<double>(vector.length) * other.fine_length +
                           static_cast<double>(vector.error) * (other.length + other.fine_length) +
                           static_cast<double>(vector.product_loss) * vector.length * other.length;
      bounds[first + k] = Around(product, error);
    }
  }
  return bounds;
}

ByteVectors::Bounds ByteVectors::Product(const Rounded& vector, std::size_t i) const {
  const Stored& other = vectors_[i];
  int32_t coarse = 0;
  int32_t fine = 0;
  int32_t other_fine = 0;
  Multiply(vector.coarse, coarse_, i, 1, &coarse);
  Multiply(vector.fine, coarse_, i, 1, &fine);
  Multiply(vector.coarse, fine_, i, 1, &other_fine);
  const double product = static_cast<double>(vector.scale) * other.scale *
                         (coarse + (static_cast<double>(fine) + other_fine) / kFineSteps);
  // f F, the products with e and with E.
  const double error =
      static_cast<double>(vector.fine_length + vector.error) * (other.fine_length + other.error) +
      static_cast<double>(vector.error) * (other.length + other.error) +
      static_cast<double>(vector.length) * other.error +
      static_cast<double>(vector.product_loss) * vector.length * other.length;
  return Around(product, error);
}

}  // namespace gluevo::nn
