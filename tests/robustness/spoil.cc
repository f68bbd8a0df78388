#include "spoil.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace gluevo::robustness {
namespace {

constexpr double kSensorNoise = 2.0;  // Gray levels.

cv::Mat WithNoise(const cv::Mat& image, double sigma, cv::RNG& random) {
  cv::Mat noise(image.size(), CV_16SC1);
  random.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::Mat sum;
  cv::add(image, noise, sum, cv::noArray(), CV_8U);
  return sum;
}

cv::Mat Cover(const cv::Size& size, cv::RNG& random) {
  cv::Mat cover(size, CV_8UC1);
  for (int row = 0; row < size.height; ++row) {
    cover.row(row).setTo(40.0 + 30.0 * row / size.height);
  }
  return WithNoise(cover, kSensorNoise, random);
}

cv::Mat SpoiltImage(const cv::Mat& image, const cv::Mat& before, Fault fault, cv::RNG& random) {
  constexpr double kBlurPx = 12.0;
  constexpr int kShiftPx = 60;
  cv::Mat spoilt(image.size(), CV_8UC1, cv::Scalar(0));
  switch (fault) {
    case Fault::kBlack:
      break;
    case Fault::kDark:
      spoilt = WithNoise(spoilt, kSensorNoise, random);
      break;
    case Fault::kWhite:
      spoilt.setTo(255);
      break;
    case Fault::kNoise:
      random.fill(spoilt, cv::RNG::UNIFORM, 0, 256);
      break;
    case Fault::kBlurred:
      cv::GaussianBlur(image, spoilt, {}, kBlurPx);
      spoilt = WithNoise(spoilt, kSensorNoise, random);
      break;
    case Fault::kCovered:
      spoilt = Cover(image.size(), random);
      break;
    case Fault::kHalfCovered: {
      const cv::Rect half(0, 0, image.cols / 2, image.rows);
      image.copyTo(spoilt);
      Cover(half.size(), random).copyTo(spoilt(half));
      break;
    }
    case Fault::kTorn: {
      const int top = image.rows / 2;
      image.copyTo(spoilt);
      image(cv::Rect(0, top, image.cols - kShiftPx, image.rows - top))
          .copyTo(spoilt(cv::Rect(kShiftPx, top, image.cols - kShiftPx, image.rows - top)));
      break;
    }
    case Fault::kFrozen:
      before.copyTo(spoilt);
      break;
  }
  return spoilt;
}

}  // namespace

std::vector<vo::StereoFrame> Spoil(std::vector<vo::StereoFrame> frames, const Case& spoiled) {
  cv::RNG random(1);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    for (const std::size_t camera : {0, 1}) {
      if (IsSpoiled(spoiled, i) && spoiled.cameras[camera]) {
        frames[i].images[camera] = SpoiltImage(frames[i].images[camera],
                                               frames[i - 1].images[camera], spoiled.fault, random);
      }
    }
  }
  return frames;
}

}  // namespace gluevo::robustness
