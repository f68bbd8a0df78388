#include "frontend_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>

#include "command_line/value_checks.h"
#include "network_options.h"
#include "option_group.h"

namespace gluevo::apps {
namespace {

constexpr const char* kLag = "--superglue-lag";

}  // namespace

void AddFrontEndOptions(CLI::App& command, vo::OdometryConfig& config) {
  vo::FrontEndConfig& frontend = config.frontend;
  OptionGroup general(command, "Options");
  general
      .Add("--method", frontend.method,
           "Front end: superglue (SuperPoint and SuperGlue, or --features and --matcher), "
           "superpoint (corners and optical flow, matched from left to right by SuperPoint's "
           "descriptors, or those of --features) or klt (corners and optical flow)")
      ->check(OneOf({"superglue", "superpoint", "klt"}));
  AddFeaturesOption(command, frontend.features);
  AddMatcherOption(command, frontend.matcher);
  // What goes with the features' default; the presets replace it.
  command.get_option("--matcher")->default_str(vo::MatcherOf(frontend.features, ""));
  AddNetworkOptions(command, frontend.networks, config.threads);
  AddKeypointOptions(command, frontend.keypoints);

  OptionGroup tuning(command, "Tuning");
  vo::LearnedFrontEndOptions& learned = frontend.learned;
  tuning
      .Add("--tracking-threshold", learned.tracking_threshold,
           "Confidence of a match from the previous left image; LightGlue's is 0.1")
      ->check(Share());
  tuning
      .Add(
          "--stereo-threshold", learned.stereo_threshold,
          "Confidence of a match from left to right with --stereo-matching network; LightGlue's is "
          "0.1")
      ->check(Share());
  tuning
      .Add("--stereo-matching", frontend.stereo_matching,
           "From left to right: band (nearest descriptors near the epipolar line) or network "
           "(--matcher, as the paper has it: more time for the same path)")
      ->check(OneOf({"band", "network"}));
  tuning.Add("--max-epipolar-error", learned.max_epipolar_error_px,
             "Largest distance of a stereo match from its epipolar line, pixels");
  tuning.Add("--min-distance", learned.min_distance_px,
             "Smallest distance between observed points, pixels");
  tuning
      .Add("--refine", frontend.refine,
           "Keypoints below the pixel: none (ALIKED's are there already), subpixel (peaks of "
           "SuperPoint's scores) or lk (optical flow between matched points, ALIKED's from the "
           "corners beside them)")
      ->check(OneOf({"none", "subpixel", "lk"}));
  tuning.Add("--min-confirmed-share", learned.min_confirmed_share,
             "With --refine lk, matches that optical flow does not confirm are dropped where it "
             "confirms this share");
  AddLightGlueOptions(command, frontend.lightglue);
  tuning.Add("--max-ratio", frontend.stereo.max_ratio,
             "Of distances to nearest and second nearest descriptor, method superpoint");
  command
      .add_flag("--rematch-keyframe", learned.rematch_keyframe,
                "Match the last key frame, too, for tracks that the frame before has lost")
      ->group("Tuning");
  tuning.Add("--recovery-keyframes", learned.recovery_keyframes,
             "Where tracking fails, match so many of the newest key frames");
  tuning
      .Add("--superglue-every", learned.network_every,
           "Run the networks on every so many-th frame at least, optical flow between")
      ->check(Within(1, 1000));
  tuning
      .Add(kLag, learned.network_lag,
           "Run the networks beside tracking, and take in what they made of a frame so many frames "
           "later; 0: frames wait for them")
      ->check(Within(0, 1000));
  tuning.Add("--klt-corners", frontend.klt.max_corners, "Corners of the klt method");
}

std::vector<std::string> UnusedFrontEndOptions(const CLI::App& command, const std::string& method,
                                               bool is_replay, const vo::FrontEndConfig& frontend) {
  constexpr std::array kOfSuperGlue = {
      "--tracking-threshold", "--stereo-threshold",    "--stereo-matching",
      "--min-distance",       "--min-confirmed-share", "--rematch-keyframe",
      "--recovery-keyframes", "--superglue-every",     kLag};
  constexpr std::array kOfOthers = {"--klt-corners", "--max-ratio"};
  constexpr std::array kOfAll = {"--refine", "--max-epipolar-error"};
  std::string unused;
  const auto name_where_given = [&](const char* option) {
    if (command.count(option) > 0) {
      unused += (unused.empty() ? "" : ", ") + std::string(option);
    }
  };
  if (is_replay || method != "superglue") {
    std::for_each(kOfSuperGlue.begin(), kOfSuperGlue.end(), name_where_given);
  }
  if (is_replay) {
    std::for_each(kOfAll.begin(), kOfAll.end(), name_where_given);
  }
  if (is_replay || method == "superglue") {
    std::for_each(kOfOthers.begin(), kOfOthers.end(), name_where_given);
  } else if (method == "klt") {
    name_where_given("--max-ratio");
  }
  std::vector<std::string> warnings;
  if (!unused.empty()) {
    warnings.push_back(
        unused + ": not used by " +
        (is_replay ? "--replay, which takes the matches as they are" : "--method " + method));
  }
  const bool runs_networks = !is_replay && method == "superglue";
  if (runs_networks && frontend.stereo_matching == "band" &&
      command.count("--stereo-threshold") > 0) {
    warnings.push_back("--stereo-threshold: used with --stereo-matching network only");
  }
  const vo::LearnedFrontEndOptions& learned = frontend.learned;
  const bool runs_late = runs_networks && command.count(kLag) > 0;
  if (runs_late && learned.network_lag > learned.network_every) {
    const std::string lag = std::to_string(learned.network_lag);
    warnings.push_back("--superglue-lag " + lag + " is more than --superglue-every " +
                       std::to_string(learned.network_every) +
                       ": the networks take up a frame when they are done with the one before, " +
                       lag + " frames later");
  }
  return warnings;
}

void DescribeLagByClock(CLI::App& command) {
  command.get_option(kLag)
      ->description(
          "Run the networks beside tracking, and take in what they made of a frame so many frames "
          "later, waiting for it; 0: frames wait for them; default: as soon as it is there")
      ->default_str("");
}

void UseLagByClock(CLI::App& command, vo::LearnedFrontEndOptions& options) {
  if (command.count(kLag) == 0) {
    options.network_lag = 1;
    options.awaits_networks = false;
    command.get_option(kLag)->default_str("as soon as it is there");
  }
}

}  // namespace gluevo::apps
