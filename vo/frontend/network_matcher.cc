#include "gluevo/vo/frontend/network_matcher.h"

#include <string>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/nn/nearest_neighbor.h"

namespace gluevo::vo {
namespace {

nn::GrayImage View(const cv::Mat& image) {
  if (image.type() != CV_8UC1) {
    throw Error("an image that is not 8-bit gray cannot be given to the networks");
  }
  return {.data = image.data,
          .width = image.cols,
          .height = image.rows,
          .stride = static_cast<std::ptrdiff_t>(image.step[0])};
}

// SuperPoint or ALIKED: the same calls.
template <typename Network, typename Options>
class NetworkExtractor final : public FeatureExtractor {
 public:
  NetworkExtractor(std::string name, std::shared_ptr<const Network> network, const Options& options,
                   nn::ThreadPool& pool)
      : name_(std::move(name)), network_(std::move(network)), options_(options), workspace_(pool) {
    options_.Validate();
  }

  std::string Name() const override { return name_; }

  nn::Features Extract(const cv::Mat& image) override {
    nn::Features features;
    network_->Extract(View(image), options_, workspace_, features);
    return features;
  }

  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& pixels) override {
    nn::Features features;
    features.keypoints = pixels;
    network_->Describe(View(image), workspace_, features);
    return features;
  }

 private:
  std::string name_;
  std::shared_ptr<const Network> network_;
  Options options_;
  nn::Workspace workspace_;
};

// SuperGlue or LightGlue.
template <typename Network, typename Options>
class NetworkPairMatcher final : public Matcher {
 public:
  NetworkPairMatcher(std::shared_ptr<const Network> network, const Options& options,
                     nn::ThreadPool& pool)
      : network_(std::move(network)), options_(options), workspace_(pool) {
    options_.Validate();
  }

  nn::Matches Match(const nn::Features& features0, const nn::Features& features1,
                    float threshold) override {
    options_.match_threshold = threshold;
    nn::Matches matches;
    network_->Match(features0, features1, options_, workspace_, matches);
    return matches;
  }

 private:
  std::shared_ptr<const Network> network_;
  Options options_;
  nn::Workspace workspace_;
};

class NearestNeighborMatcher : public Matcher {
 public:
  nn::Matches Match(const nn::Features& features0, const nn::Features& features1,
                    float threshold) override {
    return nn::MatchNearestNeighbors(features0, features1, {.min_similarity = threshold});
  }
};

}  // namespace

std::unique_ptr<FeatureExtractor> MakeSuperPointExtractor(
    std::shared_ptr<const nn::SuperPoint> network, const nn::SuperPointOptions& options,
    nn::ThreadPool& pool) {
  return std::make_unique<NetworkExtractor<nn::SuperPoint, nn::SuperPointOptions>>(
      "superpoint", std::move(network), options, pool);
}

std::unique_ptr<FeatureExtractor> MakeAlikedExtractor(std::shared_ptr<const nn::Aliked> network,
                                                      const nn::AlikedOptions& options,
                                                      nn::ThreadPool& pool) {
  return std::make_unique<NetworkExtractor<nn::Aliked, nn::AlikedOptions>>(
      "aliked", std::move(network), options, pool);
}

std::unique_ptr<Matcher> MakeSuperGlueMatcher(std::shared_ptr<const nn::SuperGlue> network,
                                              int sinkhorn_iterations, nn::ThreadPool& pool) {
  const nn::SuperGlueOptions options = {.sinkhorn_iterations = sinkhorn_iterations};
  return std::make_unique<NetworkPairMatcher<nn::SuperGlue, nn::SuperGlueOptions>>(
      std::move(network), options, pool);
}

std::unique_ptr<Matcher> MakeLightGlueMatcher(std::shared_ptr<const nn::LightGlue> network,
                                              const nn::LightGlueOptions& options,
                                              nn::ThreadPool& pool) {
  options.Validate();
  nn::LightGlueOptions possible = options;
  if (!network->has_adaptive_depth()) {
    possible.depth_confidence = 0.0F;
  }
  return std::make_unique<NetworkPairMatcher<nn::LightGlue, nn::LightGlueOptions>>(
      std::move(network), possible, pool);
}

std::unique_ptr<Matcher> MakeNearestNeighborMatcher() {
  return std::make_unique<NearestNeighborMatcher>();
}

}  // namespace gluevo::vo
