#include "gluevo/weights_tools/verify.h"

#include <cmath>
#include <iomanip>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "gluevo/nn/aliked.h"
#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "test_image.h"

namespace gluevo::weights_tools {
namespace {

using Map = nn::Features::RowMajor;

// The networks run in float: the same weights folded in another order differ by a hundredth of it.
constexpr double kAllowed = 1e-4;
// A point at the threshold may come and go.
constexpr double kAllowedPoints = 0.01;

struct Output {
  std::string name;
  Map values;
};

/// What one network gives: maps, and a set of points or of pairs of points.
struct Outputs {
  std::vector<Output> maps;
  std::string points_name;
  std::set<std::pair<int, int>> points;
};

Outputs RunSuperPoint(const nn::Weights& weights, nn::Workspace& workspace) {
  const TestImage image = MakeTestImage();
  const nn::GrayImage gray{image.pixels.data(), image.width, image.height, image.width};
  const nn::SuperPoint superpoint(weights);
  Outputs outputs{.points_name = "keypoints"};
  const nn::SuperPoint::DenseMaps maps = superpoint.Dense(gray, workspace);
  outputs.maps.push_back({"scores", maps.scores.Matrix()});
  outputs.maps.push_back({"descriptors", maps.descriptors.Matrix()});
  nn::Features features;
  superpoint.Extract(gray, {}, workspace, features);
  for (int i = 0; i < features.size(); ++i) {
    outputs.points.emplace(static_cast<int>(features.keypoints(i, 0)),
                           static_cast<int>(features.keypoints(i, 1)));
  }
  return outputs;
}

Outputs RunSuperGlue(const nn::Weights& weights, nn::Workspace& workspace) {
  constexpr int kPoints = 100;
  const nn::SuperGlue superglue(weights);
  const TestFeatures features = MakeTestFeatures(kPoints, superglue.descriptor_size());
  Outputs outputs{.points_name = "matches"};
  const auto assignment = superglue.LogAssignment(features.first, features.second, {}, workspace);
  outputs.maps.push_back({"assignment", assignment.Matrix()});
  nn::Matches matches;
  superglue.Match(features.first, features.second, {}, workspace, matches);
  for (int i = 0; i < kPoints; ++i) {
    outputs.points.emplace(i, matches.matches0[static_cast<std::size_t>(i)]);
  }
  return outputs;
}

Outputs RunLightGlue(const nn::Weights& weights, nn::Workspace& workspace) {
  constexpr int kPoints = 100;
  const nn::LightGlue lightglue(weights);
  const TestFeatures features = MakeTestFeatures(kPoints, lightglue.descriptor_size());
  Outputs outputs{.points_name = "matches"};
  const auto assignment = lightglue.LogAssignment(features.first, features.second, workspace);
  outputs.maps.push_back({"assignment", assignment.Matrix()});
  nn::LightGlueOptions options;
  options.depth_confidence = lightglue.has_adaptive_depth() ? options.depth_confidence : 0.0F;
  nn::Matches matches;
  lightglue.Match(features.first, features.second, options, workspace, matches);
  for (int i = 0; i < kPoints; ++i) {
    outputs.points.emplace(i, matches.matches0[static_cast<std::size_t>(i)]);
  }
  return outputs;
}

Outputs RunAliked(const nn::Weights& weights, nn::Workspace& workspace) {
  const TestImage image = MakeTestImage();
  const nn::GrayImage gray{image.pixels.data(), image.width, image.height, image.width};
  const nn::Aliked aliked(weights);
  Outputs outputs{.points_name = "keypoints"};
  outputs.maps.push_back({"scores", aliked.Scores(gray, workspace).Matrix()});
  nn::Features features;
  // Of points that do not depend on the weights.
  constexpr int kPoints = 100;
  features.keypoints = MakeTestFeatures(kPoints, 1).first.keypoints;
  aliked.Describe(gray, workspace, features);
  outputs.maps.push_back({"descriptors", features.descriptors});
  aliked.Extract(gray, {}, workspace, features);
  for (int i = 0; i < features.size(); ++i) {
    outputs.points.emplace(static_cast<int>(std::lround(features.keypoints(i, 0))),
                           static_cast<int>(std::lround(features.keypoints(i, 1))));
  }
  return outputs;
}

Outputs Run(const nn::Weights& weights, nn::Workspace& workspace) {
  using Runner = Outputs (*)(const nn::Weights&, nn::Workspace&);
  static const std::map<std::string, Runner> kRunners = {{"superpoint", RunSuperPoint},
                                                         {"superglue", RunSuperGlue},
                                                         {"lightglue", RunLightGlue},
                                                         {"aliked", RunAliked}};
  return kRunners.at(weights.metadata.at("architecture"))(weights, workspace);
}

double RelativeRms(const Map& expected, const Map& actual) {
  const double size = expected.cast<double>().norm();
  const double difference = (actual.cast<double>() - expected.cast<double>()).norm();
  return difference == 0 ? 0 : difference / size;
}

double ShareOfOne(const std::set<std::pair<int, int>>& a, const std::set<std::pair<int, int>>& b) {
  std::size_t both = 0;
  for (const auto& point : a) {
    both += b.contains(point) ? 1 : 0;
  }
  const std::size_t all = a.size() + b.size() - both;
  return all == 0 ? 0 : 1 - static_cast<double>(both) / static_cast<double>(all);
}

// Of a SuperGlue, with what to do where they were only assumed.
std::string HeadsOf(const nn::Weights& weights) {
  return weights.metadata.at("heads") + " attention heads" +
         (weights.metadata.contains("heads_assumed") ? " (assumed, see --heads)" : "");
}

void Compare(const nn::Weights& first, const nn::Weights& second,
             std::vector<OutputComparison>& comparisons) {
  nn::ThreadPool pool;
  nn::Workspace workspace(pool);
  const std::string& network = first.metadata.at("architecture");
  const std::string& other = second.metadata.at("descriptor_size");
  if (first.metadata.at("descriptor_size") != other) {
    throw Error(second.source + ": its descriptors are of " + other + " values, those of " +
                first.source + " of " + first.metadata.at("descriptor_size"));
  }
  if (network == "superglue" && first.metadata.at("heads") != second.metadata.at("heads")) {
    throw Error(second.source + ": has " + HeadsOf(second) + ", " + first.source + " has " +
                HeadsOf(first));
  }
  const Outputs a = Run(first, workspace);
  const Outputs b = Run(second, workspace);
  for (std::size_t i = 0; i < a.maps.size(); ++i) {
    comparisons.push_back(
        {network, a.maps[i].name, RelativeRms(a.maps[i].values, b.maps[i].values), kAllowed});
  }
  comparisons.push_back({network, a.points_name, ShareOfOne(a.points, b.points), kAllowedPoints});
}

}  // namespace

std::vector<OutputComparison> Verify(const std::filesystem::path& first,
                                     const std::filesystem::path& second,
                                     const ConvertOptions& options) {
  const std::vector<nn::Weights> firsts = Convert({first}, options);
  const std::vector<nn::Weights> seconds = Convert({second}, options);
  std::vector<OutputComparison> comparisons;
  for (const nn::Weights& a : firsts) {
    const std::string& network = a.metadata.at("architecture");
    bool found = false;
    for (const nn::Weights& b : seconds) {
      if (b.metadata.at("architecture") == network) {
        Compare(a, b, comparisons);
        found = true;
      }
    }
    if (!found) {
      throw Error(second.string() + ": holds no " + network + ", which " + first.string() +
                  " holds");
    }
  }
  return comparisons;
}

std::string VerificationText(const std::vector<OutputComparison>& comparisons) {
  std::ostringstream text;
  for (const OutputComparison& comparison : comparisons) {
    text << std::left << std::setw(12) << comparison.network << std::setw(13) << comparison.output
         << "difference " << std::setprecision(3) << std::setw(10) << comparison.difference
         << " of " << comparison.allowed << (comparison.agrees() ? "" : "  DIFFERS") << '\n';
  }
  return text.str();
}

std::string VerificationJson(const std::vector<OutputComparison>& comparisons) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const OutputComparison& comparison : comparisons) {
    json.push_back({{"network", comparison.network},
                    {"output", comparison.output},
                    {"difference", comparison.difference},
                    {"allowed", comparison.allowed},
                    {"agrees", comparison.agrees()}});
  }
  return json.dump(2) + "\n";
}

}  // namespace gluevo::weights_tools
