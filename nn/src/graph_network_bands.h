#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "kernels/kernels.h"

namespace gluevo::nn {

/// Rows [begin, begin + rows) of one image, begin a multiple of kBlock.
struct Band {
  int image = 0;
  int64_t begin = 0;
  int64_t rows = 0;
};

/// Two images' keypoints in bands of about the same height, numbered through both images.
class Bands {
 public:
  /// As high as keeps the register tiles full, and enough of them for all threads.
  Bands(std::array<int64_t, 2> keypoints, int threads) : keypoints_(keypoints) {
    const auto bands_of = [&](int64_t count) { return (count + most_rows_ - 1) / most_rows_; };
    while (most_rows_ > kernels::kBlock &&
           bands_of(keypoints[0]) + bands_of(keypoints[1]) < 4 * threads) {
      most_rows_ -= kernels::kBlock;
    }
    counts_ = {bands_of(keypoints[0]), bands_of(keypoints[1])};
  }

  int64_t size() const { return counts_[0] + counts_[1]; }
  const std::array<int64_t, 2>& counts() const { return counts_; }  ///< Of each image.
  int64_t most_rows() const { return most_rows_; }                  ///< Of any band.

  Band operator[](int64_t index) const {
    const int image = index < counts_[0] ? 0 : 1;
    const int64_t place = index - image * counts_[0];
    const int64_t blocks = kernels::BlocksOf(keypoints_[image]);
    const int64_t begin = blocks * place / counts_[image] * kernels::kBlock;
    const int64_t end = blocks * (place + 1) / counts_[image] * kernels::kBlock;
    return {image, begin, std::min(end, keypoints_[image]) - begin};
  }

  /// The band whose turn it is, from image 0's first to image 1's last, or image 1's before image
  /// 0's.
  int64_t InTurn(int64_t turn, bool image1_first) const {
    if (!image1_first) {
      return turn;
    }
    return turn < counts_[1] ? counts_[0] + turn : turn - counts_[1];
  }

 private:
  // The more rows pass through a layer together, the less often its weights are read; the fewer,
  // the closer are the rows' hidden values.
  int64_t most_rows_ = 3 * kernels::kBlock;
  std::array<int64_t, 2> keypoints_;
  std::array<int64_t, 2> counts_ = {};
};

}  // namespace gluevo::nn
