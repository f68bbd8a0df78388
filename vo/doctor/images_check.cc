#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "checks.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::vo {
namespace {

constexpr double kPercent = 100.0;

struct ImageFigures {
  double mean = 0.0;
  double spread = 0.0;     // Gray levels between the 5th and the 95th percentile.
  double white = 0.0;      // Share of pixels at 250 or above.
  double sharpness = 0.0;  // Standard deviation of the Laplacian over that of the image.
};

ImageFigures Measure(const cv::Mat& image) {
  std::array<double, 256> histogram = {};
  for (int y = 0; y < image.rows; ++y) {
    const auto* const row = image.ptr<unsigned char>(y);
    for (int x = 0; x < image.cols; ++x) {
      histogram[row[x]] += 1.0;
    }
  }
  const auto pixels = static_cast<double>(image.total());
  const auto level = [&](double share) {
    double below = 0.0;
    for (std::size_t i = 0; i < histogram.size(); ++i) {
      below += histogram[i];
      if (below >= share * pixels) {
        return static_cast<double>(i);
      }
    }
    return 255.0;
  };
  constexpr std::size_t kWhite = 250;
  ImageFigures figures;
  figures.spread = level(0.95) - level(0.05);
  for (std::size_t i = kWhite; i < histogram.size(); ++i) {
    figures.white += histogram[i] / pixels;
  }
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  figures.mean = mean[0];
  // Noise is taken out first, else the noisiest image would be the sharpest.
  cv::Mat smooth;
  cv::Mat laplacian;
  cv::GaussianBlur(image, smooth, {3, 3}, 0.0);
  cv::Laplacian(smooth, laplacian, CV_32F);
  cv::Scalar ignored;
  cv::Scalar edges;
  cv::meanStdDev(laplacian, ignored, edges);
  figures.sharpness = deviation[0] > 0.0 ? edges[0] / deviation[0] : 0.0;
  return figures;
}

/// Images of one gray value are alike without being copies.
bool AreEqual(const cv::Mat& a, const cv::Mat& b) {
  double least = 0.0;
  double most = 0.0;
  cv::minMaxLoc(a, &least, &most);
  return least < most && a.size() == b.size() && a.type() == b.type() &&
         cv::norm(a, b, cv::NORM_INF) == 0.0;
}

double MedianOf(const std::vector<ImageFigures>& figures, double ImageFigures::*figure) {
  std::vector<double> values;
  values.reserve(figures.size());
  for (const ImageFigures& image : figures) {
    values.push_back(image.*figure);
  }
  return Median(std::move(values));
}

Findings CheckLight(const std::array<std::vector<ImageFigures>, 2>& figures) {
  Findings findings;
  constexpr const char* kSides[] = {"left", "right"};
  for (std::size_t side = 0; side < 2; ++side) {
    const double mean = MedianOf(figures[side], &ImageFigures::mean);
    const double spread = MedianOf(figures[side], &ImageFigures::spread);
    const double white = kPercent * MedianOf(figures[side], &ImageFigures::white);
    // Corners must stand out of noise of some 2 gray levels; rooms and streets span 60 to 200.
    constexpr double kClear = 30.0;
    constexpr double kVisible = 12.0;
    constexpr double kMuchWhite = 30.0;
    Verdict verdict = spread >= kClear     ? Verdict::kGood
                      : spread >= kVisible ? Verdict::kSuspicious
                                           : Verdict::kWrong;
    if (white > kMuchWhite && verdict == Verdict::kGood) {
      verdict = Verdict::kSuspicious;
    }
    findings.push_back(
        {verdict, std::string("light, ") + kSides[side],
         "mean " + FixedText(mean, 0) + ", nine tenths within " + FixedText(spread, 0) +
             " gray levels, " + FixedText(white, 0) + " % white",
         spread < kClear ? "at least 30 gray levels: images too dark, without texture, or of "
                           "10 or 12 bits in 16"
                         : "at least 30 gray levels, up to 30 % white"});
  }
  const double difference =
      MedianOf(figures[0], &ImageFigures::mean) - MedianOf(figures[1], &ImageFigures::mean);
  constexpr double kAlike = 40.0;
  findings.push_back({UpTo(std::abs(difference), kAlike, 256.0), "light, left less right",
                      FixedText(difference, 0) + " gray levels",
                      "up to 40 either way: cameras exposed alike match better"});
  return findings;
}

Finding CheckSharpness(const std::array<std::vector<ImageFigures>, 2>& figures) {
  const double left = MedianOf(figures[0], &ImageFigures::sharpness);
  const double right = MedianOf(figures[1], &ImageFigures::sharpness);
  // A lens out of focus or a dirty one halves it; below a hundredth no corner is left.
  constexpr double kSharp = 0.02;
  constexpr double kAlike = 2.0;
  const double least = std::min(left, right);
  const double ratio = least > 0.0 ? std::max(left, right) / least : 0.0;
  const bool odd = least < kSharp || ratio > kAlike;
  return {odd ? Verdict::kSuspicious : Verdict::kGood, "sharpness",
          "left " + FixedText(left, 3) + ", right " + FixedText(right, 3),
          "both above 0.02 and within a factor of 2: is a lens out of focus?"};
}

Finding CheckEqual(const std::string& topic, std::size_t equal, std::size_t count,
                   const std::string& why) {
  const double share = static_cast<double>(equal) / static_cast<double>(count);
  // A camera at rest still has noise: equal bytes are copies.
  constexpr double kMany = 0.5;
  return {equal == 0      ? Verdict::kGood
          : share < kMany ? Verdict::kSuspicious
                          : Verdict::kWrong,
          topic, std::to_string(equal) + " of " + std::to_string(count), "none: " + why};
}

}  // namespace

Findings CheckImages(const std::vector<StereoFrame>& pairs, const std::vector<cv::Mat>& followers) {
  std::array<std::vector<ImageFigures>, 2> figures;
  std::size_t equal_sides = 0;
  std::size_t equal_next = 0;
  std::size_t with_next = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (std::size_t side = 0; side < 2; ++side) {
      figures[side].push_back(Measure(pairs[i].images[side]));
    }
    equal_sides += AreEqual(pairs[i].images[0], pairs[i].images[1]) ? 1 : 0;
    if (i < followers.size() && !followers[i].empty()) {
      ++with_next;
      equal_next += AreEqual(pairs[i].images[0], followers[i]) ? 1 : 0;
    }
  }
  if (pairs.empty()) {
    return {};
  }
  Findings findings = CheckLight(figures);
  findings.push_back(CheckSharpness(figures));
  findings.push_back(CheckEqual("left and right images that are equal", equal_sides, pairs.size(),
                                "is one camera's folder a copy of the other's?"));
  if (with_next > 0) {
    findings.push_back(CheckEqual("images equal to the next one", equal_next, with_next,
                                  "does the recorder repeat frames?"));
  }
  return findings;
}

}  // namespace gluevo::vo
