#include "frontend_options.h"

#include <CLI/CLI.hpp>
#include <utility>

#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/frontend/superpoint_frontend.h"
#include "option_defaults.h"

namespace gluevo::apps {

void AddFrontEndOptions(CLI::App& command, FrontEndArguments& arguments) {
  command
      .add_option(
          "--method", arguments.method,
          "Front end: superglue (SuperPoint and SuperGlue), superpoint (corners and optical "
          "flow, matched from left to right by SuperPoint's descriptors) or klt (corners "
          "and optical flow)")
      ->check(CLI::IsMember({"superglue", "superpoint", "klt"}))
      ->capture_default_str();
  command
      .add_option("--matcher", arguments.matcher,
                  "What matches SuperPoint's keypoints: superglue, or nn for mutual nearest "
                  "neighbours")
      ->check(CLI::IsMember({"superglue", "nn"}))
      ->capture_default_str();
  AddNetworkOptions(command, arguments.networks);

  AddSuperPointOptions(command, arguments.superpoint);
  const auto tune = [&command](const char* name, auto& value, const char* help) {
    return command.add_option(name, value, help)->capture_default_str()->group("Tuning");
  };
  vo::LearnedFrontEndOptions& learned = arguments.learned;
  tune("--tracking-threshold", learned.tracking_threshold,
       "Confidence of a match from the previous left image");
  tune("--stereo-threshold", learned.stereo_threshold, "Confidence of a match from left to right");
  tune("--max-epipolar-error", learned.max_epipolar_error_px,
       "Largest distance of a stereo match from its epipolar line, pixels");
  tune("--min-distance", learned.min_distance_px,
       "Smallest distance between observed points, pixels");
  tune("--refine", arguments.refine,
       "Keypoints below the pixel: none, subpixel (peaks of SuperPoint's scores) or lk (optical "
       "flow between matched points)")
      ->check(CLI::IsMember({"none", "subpixel", "lk"}));
  tune("--min-confirmed-share", learned.min_confirmed_share,
       "With --refine lk, matches that optical flow does not confirm are dropped where it confirms "
       "this share");
  tune("--max-ratio", arguments.stereo.max_ratio,
       "Of distances to nearest and second nearest descriptor, method superpoint");
  command
      .add_flag("--rematch-keyframe", learned.rematch_keyframe,
                "Match the last key frame, too, for tracks that the frame before has lost")
      ->group("Tuning");
  tune("--recovery-keyframes", learned.recovery_keyframes,
       "Where tracking fails, match so many of the newest key frames");
  tune("--superglue-every", learned.network_every,
       "Run the networks on every so many-th frame at least, optical flow between")
      ->check(CLI::Range(1, 1000));
  tune("--klt-corners", arguments.klt.max_corners, "Corners of the klt method");
}

void ApplyMethodDefaults(CLI::App& command, const FrontEndArguments& arguments) {
  if (arguments.method == "superpoint") {
    // Tracks need not lie on the strongest keypoints of the right image.
    SetUnlessGiven(command, "--keypoint-threshold", "0.0005");
    SetUnlessGiven(command, "--max-keypoints", "1500");
  }
}

Networks LoadFrontEndNetworks(const FrontEndArguments& arguments) {
  if (arguments.method == "klt") {
    return {};
  }
  return LoadNetworks(arguments.networks,
                      arguments.method == "superglue" && arguments.matcher == "superglue");
}

std::unique_ptr<vo::FrontEnd> MakeFrontEnd(const FrontEndArguments& arguments,
                                           const vo::StereoRig& rig, const Networks& networks,
                                           nn::ThreadPool& pool) {
  if (arguments.method == "klt") {
    return std::make_unique<vo::KltFrontEnd>(rig, arguments.klt);
  }
  nn::SuperPointOptions superpoint = arguments.superpoint;
  superpoint.subpixel = arguments.refine == "subpixel";
  std::unique_ptr<vo::FeatureExtractor> extractor =
      vo::MakeSuperPointExtractor(networks.superpoint, superpoint, pool);
  if (arguments.method == "superpoint") {
    vo::SuperPointFrontEndOptions options = arguments.stereo;
    options.klt = arguments.klt;
    options.max_epipolar_error_px = arguments.learned.max_epipolar_error_px;
    options.refine = arguments.refine == "lk";
    return std::make_unique<vo::SuperPointFrontEnd>(rig, std::move(extractor), options);
  }
  constexpr int kSinkhornIterations = 100;
  std::unique_ptr<vo::Matcher> matcher =
      networks.superglue != nullptr
          ? vo::MakeSuperGlueMatcher(networks.superglue, kSinkhornIterations, pool)
          : vo::MakeNearestNeighborMatcher();
  vo::LearnedFrontEndOptions learned = arguments.learned;
  learned.refine = arguments.refine == "lk";
  return std::make_unique<vo::LearnedFrontEnd>(rig, std::move(extractor), std::move(matcher),
                                               vo::MakeNearestNeighborMatcher(), learned);
}

}  // namespace gluevo::apps
