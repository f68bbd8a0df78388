#include "gluevo/vo/pipeline/networks.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/nn/weights.h"
#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/pipeline/network_files.h"
#include "name_check.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

nn::SuperPointOptions ForSuperPoint(const KeypointOptions& options) {
  return {.keypoint_threshold = options.keypoint_threshold,
          .max_keypoints = options.max_keypoints,
          .subpixel = options.subpixel};
}

nn::Weights ReadWeightsOf(const NetworkFiles& files, const std::string& network,
                          const std::string& features, Networks& networks) {
  const std::optional<fs::path> file = FindWeights(files, network, features);
  nn::Weights weights = file                      ? nn::ReadWeights(*file)
                        : network == "superpoint" ? nn::OpenSuperPointWeights()
                                                  : nn::OpenSuperGlueWeights();
  networks.records.push_back({network, weights.source, weights.checksum});
  return weights;
}

// A file that nothing would read is a mistake in the choice of networks.
void CheckFilesAreRead(const NetworkFiles& files, const std::string& features,
                       const std::string& matcher) {
  const auto refuse = [](const fs::path& file, const std::string& network, const char* option,
                         const std::string& chosen) {
    if (!file.empty()) {
      throw OptionError(file.string() + ": weights of --" + network + ", which --" + option + " " +
                        chosen + " does not run: expected --" + option + " " + network);
    }
  };
  if (features == "aliked") {
    refuse(files.superpoint, "superpoint", "features", features);
  } else if (features == "superpoint") {
    refuse(files.aliked, "aliked", "features", features);
  }
  if (matcher == "lightglue") {
    refuse(files.superglue, "superglue", "matcher", matcher);
  } else if (matcher == "superglue") {
    refuse(files.lightglue, "lightglue", "matcher", matcher);
  }
}

// A folder need not hold both networks of a pair.
void CheckFolder(const NetworkFiles& files, const std::string& features,
                 const std::string& matcher) {
  std::vector<std::string> networks;
  if (!features.empty()) {
    networks = {features, MatcherOf(features, "")};
  }
  const bool is_network = matcher == "superglue" || matcher == "lightglue";
  if (is_network && std::find(networks.begin(), networks.end(), matcher) == networks.end()) {
    networks.push_back(matcher);
  }
  if (!files.weights.empty() && !networks.empty()) {
    CheckFolderHolds(files.weights, networks);
  }
}

void CheckSizes(const Networks& networks) {
  const int of_features = networks.superpoint != nullptr ? networks.superpoint->descriptor_size()
                                                         : networks.aliked->descriptor_size();
  const bool is_superglue = networks.superglue != nullptr;
  const int of_matcher =
      is_superglue ? networks.superglue->descriptor_size() : networks.lightglue->descriptor_size();
  if (of_features != of_matcher) {
    throw Error(networks.records.back().source + ": a " +
                (is_superglue ? "SuperGlue" : "LightGlue") + " for descriptors of " +
                std::to_string(of_matcher) + " values cannot match those of " +
                networks.records.front().source + ", which have " + std::to_string(of_features) +
                " (--matcher nn matches any)");
  }
}

void CheckTrainedOn(const nn::Weights& lightglue, const std::string& features) {
  const auto found = lightglue.metadata.find("features");
  if (found != lightglue.metadata.end() && !features.empty() && found->second != features) {
    throw Error(lightglue.source + ": a LightGlue trained on " + Quoted(found->second) +
                " (so its metadata say) cannot match features of " + Quoted(features));
  }
}

void AddMatcher(const NetworkFiles& files, const std::string& features, const std::string& matcher,
                Networks& networks) {
  if (matcher == "superglue") {
    networks.superglue = std::make_shared<nn::SuperGlue>(
        ReadWeightsOf(files, "superglue", features, networks),
        files.precision == "bf16" ? nn::Precision::kBf16 : nn::Precision::kFloat);
  } else if (matcher == "lightglue") {
    const nn::Weights weights = ReadWeightsOf(files, "lightglue", features, networks);
    CheckTrainedOn(weights, features);
    networks.lightglue = std::make_shared<nn::LightGlue>(weights);
  }
}

}  // namespace

void KeypointOptions::Validate() const { ForSuperPoint(*this).Validate(); }

float UsualKeypointThreshold(const std::string& features) {
  return features == "aliked" ? nn::AlikedOptions().keypoint_threshold
                              : nn::SuperPointOptions().keypoint_threshold;
}

float UsualMatchThreshold(const std::string& matcher) {
  return matcher == "lightglue" ? nn::LightGlueOptions().match_threshold
                                : nn::SuperGlueOptions().match_threshold;
}

std::string MatcherOf(const std::string& features, const std::string& matcher) {
  return !matcher.empty() ? matcher : features == "aliked" ? "lightglue" : "superglue";
}

void CheckNetworkNames(const std::string& features, const std::string& matcher) {
  CheckName(features, {"superpoint", "aliked"}, "features");
  if (!matcher.empty()) {
    CheckName(matcher, {"superglue", "lightglue", "nn"}, "matcher");
  }
  if (features == "aliked" && matcher == "superglue") {
    throw OptionError(
        "option matcher is \"superglue\", which matches SuperPoint's descriptors: for features "
        "\"aliked\" expected lightglue or nn");
  }
}

Networks LoadNetworks(const NetworkFiles& files, const std::string& features,
                      const std::string& matcher) {
  CheckNetworkNames(features, matcher);
  CheckFilesAreRead(files, features, matcher);
  CheckFolder(files, features, matcher);
  Networks networks;
  if (features == "superpoint") {
    networks.superpoint =
        std::make_shared<nn::SuperPoint>(ReadWeightsOf(files, "superpoint", features, networks));
  } else if (features == "aliked") {
    networks.aliked =
        std::make_shared<nn::Aliked>(ReadWeightsOf(files, "aliked", features, networks));
  }
  AddMatcher(files, features, matcher, networks);
  if (networks.records.size() == 2) {
    CheckSizes(networks);
  }
  return networks;
}

Networks LoadMatcher(const NetworkFiles& files, const std::string& features,
                     const std::string& matcher) {
  if (!features.empty()) {
    CheckNetworkNames(features, matcher);
  }
  CheckFilesAreRead(files, features, matcher);
  CheckFolder(files, features, matcher);
  Networks networks;
  AddMatcher(files, features, matcher, networks);
  return networks;
}

std::unique_ptr<FeatureExtractor> MakeExtractor(const Networks& networks,
                                                const KeypointOptions& options,
                                                nn::ThreadPool& pool) {
  if (networks.aliked != nullptr) {
    return MakeAlikedExtractor(
        networks.aliked,
        {.keypoint_threshold = options.keypoint_threshold, .max_keypoints = options.max_keypoints},
        pool);
  }
  return MakeSuperPointExtractor(networks.superpoint, ForSuperPoint(options), pool);
}

std::unique_ptr<Matcher> MakeMatcher(const Networks& networks, nn::ThreadPool& pool,
                                     const nn::LightGlueOptions& lightglue) {
  if (networks.lightglue != nullptr) {
    return MakeLightGlueMatcher(networks.lightglue, lightglue, pool);
  }
  constexpr int kSinkhornIterations = 100;  // As published.
  return networks.superglue != nullptr
             ? MakeSuperGlueMatcher(networks.superglue, kSinkhornIterations, pool)
             : MakeNearestNeighborMatcher();
}

}  // namespace gluevo::vo
