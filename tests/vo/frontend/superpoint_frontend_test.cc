#include "gluevo/vo/frontend/superpoint_frontend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "band_matching.h"
#include "gluevo/nn/error.h"
#include "scripted_networks.h"
#include "textured_views.h"

namespace gluevo::vo {
namespace {

nn::Features Described(const std::vector<Eigen::Vector3f>& descriptors) {
  nn::Features features;
  const auto count = static_cast<Eigen::Index>(descriptors.size());
  features.keypoints.setZero(count, 2);
  features.scores.setZero(count);
  features.descriptors.resize(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector3f& d = descriptors[i];
    const float norm = std::sqrt(d.x() * d.x() + d.y() * d.y() + d.z() * d.z());
    features.descriptors.row(i) << d.x() / norm, d.y() / norm, d.z() / norm;
  }
  return features;
}

TEST(BandMatchingTest, OnlyTheBandCompetes) {
  const EpipolarCheck epipolar(testing::RectifiedRig());
  const nn::Features left = Described({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}});
  const nn::Features right = Described({{1, 0, 0}, {1, 0.1F, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector2d> left_rays = {{0, 0}, {0, 0.2}, {0, 0.4}, {nan, nan}};
  // The best for 0 is off its line, the best for 1 on it, the best for 2 would be behind.
  const std::vector<Eigen::Vector2d> right_rays = {
      {-0.1, 0.2}, {-0.1, 0.0}, {-0.1, 0.2}, {0.3, 0.4}, {0, 0}};
  const nn::Matches matches = MatchInBand(left, left_rays, right, right_rays, epipolar, 2.0, 0.9);
  EXPECT_EQ(matches.matches0, (std::vector<int>{1, 2, -1, -1}));
  EXPECT_NEAR(matches.scores0[0], 1.0 / std::sqrt(1.01), 1e-6);
  EXPECT_EQ(matches.scores0[2], 0.0F);
}

TEST(BandMatchingTest, RatioAndMutualCheck) {
  const EpipolarCheck epipolar(testing::RectifiedRig());
  const auto match = [&](const nn::Features& left, const nn::Features& right, double ratio) {
    const std::vector<Eigen::Vector2d> left_rays(static_cast<std::size_t>(left.size()),
                                                 Eigen::Vector2d(0, 0));
    const std::vector<Eigen::Vector2d> right_rays(static_cast<std::size_t>(right.size()),
                                                  Eigen::Vector2d(-0.1, 0));
    return MatchInBand(left, left_rays, right, right_rays, epipolar, 2.0, ratio).matches0;
  };
  const nn::Features one = Described({{1, 0, 0}});
  const nn::Features alike = Described({{1, 0.10F, 0}, {1, 0.11F, 0}});
  EXPECT_EQ(match(one, alike, 0.8), std::vector<int>{-1});
  EXPECT_EQ(match(one, alike, 1.0), std::vector<int>{0});
  EXPECT_EQ(match(one, one, 0.8), std::vector<int>{0});  // No second one.
  EXPECT_EQ(match(alike, one, 1.0), (std::vector<int>{0, -1}));
  EXPECT_EQ(match(one, Described({}), 1.0), std::vector<int>{-1});
  nn::Features shorter = Described({{1, 0, 0}});
  shorter.descriptors.resize(1, 2);
  EXPECT_THROW(match(one, shorter, 1.0), Error);
}

// Describes a point by its column of the pattern, detects on whole pixels.
class PatternExtractor : public FeatureExtractor {
 public:
  explicit PatternExtractor(double shift) : shift_(shift) {}
  nn::Features Extract(const cv::Mat& image) override {
    nn::Features::Points pixels(64 * 48 / 64, 2);
    for (int i = 0; i < pixels.rows(); ++i) {
      const int row = i / 8;
      pixels.row(i) << static_cast<float>(4 + i % 8 * 8), static_cast<float>(4 + row * 8);
    }
    return At(image, pixels, shift_);
  }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& pixels) override {
    return At(image, pixels, 0.0);
  }

 private:
  static nn::Features At(const cv::Mat& /*image*/, const nn::Features::Points& pixels,
                         double shift) {
    nn::Features features;
    features.keypoints = pixels;
    features.scores.setOnes(pixels.rows());
    features.descriptors.resize(pixels.rows(), 2);
    for (Eigen::Index i = 0; i < pixels.rows(); ++i) {
      const double angle = 0.02 * (pixels(i, 0) - shift);
      features.descriptors.row(i) << static_cast<float>(std::cos(angle)),
          static_cast<float>(std::sin(angle));
    }
    return features;
  }
  double shift_;
};

TEST(SuperPointFrontEndTest, TracksLeftAndFindsTheRightPointBelowThePixel) {
  constexpr double kDisparity = 3.4;
  for (const bool refine : {false, true}) {
    SCOPED_TRACE(refine);
    SuperPointFrontEndOptions options;
    options.klt = {.max_corners = 12, .min_distance = 8, .window = 11, .levels = 1};
    options.max_ratio = 1.0;
    options.max_epipolar_error_px = 5.0;
    options.refine = refine;
    options.refinement = {.window = 11, .levels = 1};
    SuperPointFrontEnd frontend(testing::RectifiedRig(),
                                std::make_unique<PatternExtractor>(-kDisparity), options);
    StereoFrame frame{1, {testing::PatternAt(0, 0), testing::PatternAt(-kDisparity, 0)}};
    const TrackedFrame first = frontend.Track(frame);
    frame = {2, {testing::PatternAt(1.5, 0.5), testing::PatternAt(1.5 - kDisparity, 0.5)}};
    const TrackedFrame second = frontend.Track(frame);
    ASSERT_FALSE(first.observations.empty());
    ASSERT_FALSE(second.observations.empty());
    EXPECT_EQ(first.observations[0].track_id, second.observations[0].track_id);
    EXPECT_TRUE(second.stages_ms.contains("features"));
    int stereo = 0;
    double worst = 0.0;
    for (const Observation& observation : first.observations) {
      if (observation.has_right) {
        ++stereo;
        worst = std::max(
            worst, std::abs(observation.left_pixel.x() - observation.right_pixel.x() - kDisparity));
        EXPECT_GT(observation.stereo_confidence, 0.9F);
        EXPECT_NEAR(observation.right.x(), (observation.right_pixel.x() - 32.0) / 50.0, 1e-6);
      } else {
        EXPECT_EQ(observation.stereo_confidence, 0.0F);
      }
    }
    EXPECT_GE(stereo, 3);
    if (refine) {
      EXPECT_LT(worst, 0.1);
    } else {
      EXPECT_GT(worst, 0.1);
    }
  }
}

TEST(SuperPointFrontEndTest, RefusesBadOptions) {
  EXPECT_THROW((SuperPointFrontEndOptions{.max_ratio = 0.0}).Validate(), Error);
  EXPECT_THROW((SuperPointFrontEndOptions{.max_epipolar_error_px = 0.0}).Validate(), Error);
  EXPECT_THROW((SuperPointFrontEndOptions{.max_refinement_px = -1.0}).Validate(), Error);
  EXPECT_THROW((SuperPointFrontEndOptions{.klt = {.max_corners = 0}}).Validate(), Error);
}

}  // namespace
}  // namespace gluevo::vo
