#include "frontend_options.h"

#include <utility>

#include "gluevo/vo/network_matcher.h"

namespace gluevo::apps {

void AddFrontEndOptions(CLI::App& command, FrontEndArguments& arguments) {
  command
      .add_option("--method", arguments.method,
                  "Front end: superglue (SuperPoint and SuperGlue) or klt (corners and optical "
                  "flow)")
      ->check(CLI::IsMember({"superglue", "klt"}))
      ->capture_default_str();
  command
      .add_option("--matcher", arguments.matcher,
                  "What matches SuperPoint's keypoints: superglue, or nn for mutual nearest "
                  "neighbours")
      ->check(CLI::IsMember({"superglue", "nn"}))
      ->capture_default_str();
  AddNetworkOptions(command, arguments.networks);

  const std::string tuning = "Tuning";
  AddSuperPointOptions(command, arguments.superpoint);
  command
      .add_option("--tracking-threshold", arguments.learned.tracking_threshold,
                  "Confidence of a match from the previous left image")
      ->capture_default_str()
      ->group(tuning);
  command
      .add_option("--stereo-threshold", arguments.learned.stereo_threshold,
                  "Confidence of a match from left to right")
      ->capture_default_str()
      ->group(tuning);
  command
      .add_option("--max-epipolar-error", arguments.learned.max_epipolar_error_px,
                  "Largest distance of a stereo match from its epipolar line, pixels")
      ->capture_default_str()
      ->group(tuning);
  command
      .add_option("--min-distance", arguments.learned.min_distance_px,
                  "Smallest distance between observed points, pixels")
      ->capture_default_str()
      ->group(tuning);
  command.add_option("--klt-corners", arguments.klt.max_corners, "Corners of the klt method")
      ->capture_default_str()
      ->group(tuning);
}

Networks LoadFrontEndNetworks(const FrontEndArguments& arguments) {
  if (arguments.method == "klt") {
    return {};
  }
  return LoadNetworks(arguments.networks, arguments.matcher == "superglue");
}

std::unique_ptr<vo::FrontEnd> MakeFrontEnd(const FrontEndArguments& arguments,
                                           const vo::StereoRig& rig, const Networks& networks,
                                           nn::ThreadPool& pool) {
  if (arguments.method == "klt") {
    return std::make_unique<vo::KltFrontEnd>(rig, arguments.klt);
  }
  constexpr int kSinkhornIterations = 100;
  std::unique_ptr<vo::Matcher> matcher =
      networks.superglue != nullptr
          ? vo::MakeSuperGlueMatcher(networks.superglue, kSinkhornIterations, pool)
          : vo::MakeNearestNeighborMatcher();
  return std::make_unique<vo::LearnedFrontEnd>(
      rig, vo::MakeSuperPointExtractor(networks.superpoint, arguments.superpoint, pool),
      std::move(matcher), vo::MakeNearestNeighborMatcher(), arguments.learned);
}

}  // namespace gluevo::apps
