// gluevo match: SuperGlue, LightGlue or mutual nearest neighbours over listed pairs or two images.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <sstream>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/frontend/feature_files.h"
#include "gluevo/vo/io/image_file.h"
#include "homography.h"
#include "interruption.h"
#include "json_text.h"
#include "match_drawing.h"
#include "named_extraction.h"
#include "options/network_options.h"
#include "pair_list.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct MatchArguments {
  std::vector<fs::path> inputs;
  fs::path pairs;
  fs::path output;
  fs::path draw;
  fs::path homography;
  double max_error_px = 3.0;
  bool json = false;
  std::string features = "superpoint";
  bool features_given = false;
  std::string matcher;             // Empty: what goes with the features.
  std::optional<float> threshold;  // Of matches and of keypoints: what suits, where not given.
  std::optional<float> keypoint_threshold;
  int max_keypoints = 1024;
  nn::LightGlueOptions lightglue;
  vo::NetworkFiles networks;
  int threads = 0;
};

std::string MatcherOf(const MatchArguments& arguments) {
  return vo::MatcherOf(arguments.features, arguments.matcher);
}

// A cosine is no confidence of a matcher that was trained: nearest neighbours take all.
float Threshold(const MatchArguments& arguments) {
  const std::string matcher = MatcherOf(arguments);
  return matcher == "nn" ? 0.0F : arguments.threshold.value_or(vo::UsualMatchThreshold(matcher));
}

int CountMatches(const nn::Matches& matches) {
  return static_cast<int>(std::count_if(matches.matches0.begin(), matches.matches0.end(),
                                        [](int match) { return match >= 0; }));
}

// Errors name the file and the pair.
nn::Matches MatchNamed(vo::Matcher& matcher, const vo::FeatureReader& reader,
                       const std::pair<std::string, std::string>& pair,
                       const MatchArguments& arguments) {
  const nn::Features features0 = reader.Read(pair.first);
  const nn::Features features1 = reader.Read(pair.second);
  try {
    return matcher.Match(features0, features1, Threshold(arguments));
  } catch (const Error& error) {
    throw Error(arguments.inputs[0].string() + ": pair " + Quoted(pair.first) + ", " +
                Quoted(pair.second) + ": " + error.what() +
                " (--features and --matcher choose networks)");
  }
}

void MatchFile(const MatchArguments& arguments) {
  const Interruption interruption;
  std::vector<fs::path> inputs = WeightsInputs(arguments.networks);
  inputs.insert(inputs.end(), {arguments.inputs[0], arguments.pairs});
  CheckOutputsAreNoInputs({arguments.output}, inputs);
  nn::CheckReplacesOnly(arguments.output, nn::kHdf5Mark, "an HDF5 file");
  const vo::FeatureReader reader(arguments.inputs[0]);
  const PairList list = ReadPairList(arguments.pairs, reader.images());
  const auto& pairs = list.pairs;
  nn::ThreadPool pool(arguments.threads);
  const vo::Networks networks = vo::LoadMatcher(
      arguments.networks, arguments.features_given ? arguments.features : "", MatcherOf(arguments));
  const std::unique_ptr<vo::Matcher> matcher = vo::MakeMatcher(networks, pool, arguments.lightglue);

  vo::MatchWriter writer(arguments.output);
  std::size_t total = 0;
  {
    Progress progress("pair", pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      // A file that lacks pairs would pass for a whole one: what is done is given up.
      Interruption::Check();
      const auto& [name0, name1] = pairs[i];
      const nn::Matches matches = MatchNamed(*matcher, reader, pairs[i], arguments);
      writer.Add(name0, name1, matches);
      total += static_cast<std::size_t>(CountMatches(matches));
      progress.Update(i + 1, vo::Counted(CountMatches(matches), "match", "matches"));
    }
  }
  writer.Finish();
  std::cout << vo::Counted(pairs.size(), "pair") << ", " << vo::Counted(total, "match", "matches")
            << ": " << OneLine(arguments.output.string()) << '\n';
  if (list.repeated > 0) {
    std::cout << vo::Counted(list.repeated, "line of the list repeats", "lines of the list repeat")
              << " a pair, which is matched once\n";
  }
  if (list.renamed > 0) {
    std::cout << vo::Counted(list.renamed, "pair is", "pairs are")
              << " stored under the names that the features have\n";
  }
}

cv::Mat ReadImage(const fs::path& file, int gray_bits) {
  const vo::GrayImage image = vo::ReadGrayImage(file, gray_bits);
  if (image.orientation != 1) {
    PrintMessage("gluevo: note",
                 file.string() + ": the file asks to be turned (EXIF), which is never done");
  }
  return image.pixels;
}

void MatchImages(const MatchArguments& arguments) {
  CheckOutputsAreNoInputs({arguments.draw},
                          {arguments.inputs[0], arguments.inputs[1], arguments.homography});
  if (!arguments.draw.empty()) {
    CheckPlaceForDrawing(arguments.draw);
  }
  std::optional<cv::Matx33d> homography;
  if (!arguments.homography.empty()) {
    homography = ReadHomography(arguments.homography);
  }
  const int gray_bits = vo::GrayBits(arguments.inputs);
  const cv::Mat images[] = {ReadImage(arguments.inputs[0], gray_bits),
                            ReadImage(arguments.inputs[1], gray_bits)};
  nn::ThreadPool pool(arguments.threads);
  const vo::Networks networks =
      vo::LoadNetworks(arguments.networks, arguments.features, MatcherOf(arguments));
  const std::unique_ptr<vo::FeatureExtractor> extractor = vo::MakeExtractor(
      networks,
      {.keypoint_threshold =
           arguments.keypoint_threshold.value_or(vo::UsualKeypointThreshold(arguments.features)),
       .max_keypoints = arguments.max_keypoints},
      pool);
  const nn::Features features0 = ExtractNamed(*extractor, images[0], arguments.inputs[0]);
  const nn::Features features1 = ExtractNamed(*extractor, images[1], arguments.inputs[1]);
  const nn::Matches matches = vo::MakeMatcher(networks, pool, arguments.lightglue)
                                  ->Match(features0, features1, Threshold(arguments));
  const int count = CountMatches(matches);

  if (!arguments.draw.empty()) {
    DrawMatches(arguments.draw, images[0], images[1], features0, features1, matches);
  }
  std::optional<int> right;
  if (homography) {
    right = CountNear(features0, features1, matches, *homography, arguments.max_error_px);
  }
  if (arguments.json) {
    nlohmann::ordered_json json;
    json["keypoints0"] = features0.size();
    json["keypoints1"] = features1.size();
    json["matches"] = nlohmann::ordered_json::array();
    for (int i = 0; i < features0.size(); ++i) {
      const int match = matches.matches0[i];
      if (match >= 0) {
        json["matches"].push_back({{"x0", features0.keypoints(i, 0)},
                                   {"y0", features0.keypoints(i, 1)},
                                   {"x1", features1.keypoints(match, 0)},
                                   {"y1", features1.keypoints(match, 1)},
                                   {"score", matches.scores0[i]}});
      }
    }
    if (right) {
      json["right"] = *right;
      json["precision"] = count > 0 ? static_cast<double>(*right) / count : 0.0;
    }
    std::cout << JsonText(json);
    return;
  }
  std::cout << features0.size() << " and " << features1.size() << " keypoints, "
            << vo::Counted(count, "match", "matches") << "\n";
  if (right) {
    std::cout << *right << " right within " << arguments.max_error_px << " px, precision "
              << std::fixed << std::setprecision(3)
              << (count > 0 ? static_cast<double>(*right) / count : 0.0) << '\n';
  }
}

}  // namespace

void AddMatchCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "match", "SuperGlue or LightGlue over pairs of a features file, or two images");
  const auto arguments = std::make_shared<MatchArguments>();
  command->add_option("INPUT", arguments->inputs, "features.h5, or two images")
      ->required()
      ->expected(1, 2);
  command->add_option("--pairs", arguments->pairs,
                      "Pairs to match, \"name0 name1\" a line, and what may follow");
  command->add_option("-o,--output", arguments->output, "HDF5 file to write the matches to");
  command->add_option("--draw", arguments->draw, "Image file to draw the matches of two images to");
  command->add_flag("--json", arguments->json, "Print the matches of two images as JSON");
  command->add_option("--homography", arguments->homography,
                      "File with the homography from the first to the second image: counts the "
                      "right matches");
  command
      ->add_option("--max-error", arguments->max_error_px,
                   "A match this close to the homography is right, pixels")
      ->check(Above(0.0))
      ->capture_default_str();
  AddFeaturesOption(*command, arguments->features);
  AddMatcherOption(*command, arguments->matcher);
  command
      ->add_option("--match-threshold", arguments->threshold,
                   "Confidence above which pairs are matches; default: 0.2 of SuperGlue, 0.1 of "
                   "LightGlue")
      ->check(Share());
  AddKeypointOptions(*command, arguments->keypoint_threshold, arguments->max_keypoints);
  AddLightGlueOptions(*command, arguments->lightglue);
  AddNetworkOptions(*command, arguments->networks, arguments->threads);
  command->footer(
      "Examples:\n  gluevo match features.h5 --pairs pairs.txt -o matches.h5\n"
      "  gluevo match a.png b.png --draw matches.png");
  command->callback([arguments, command] {
    arguments->features_given = command->count("--features") > 0;
    const bool images = arguments->inputs.size() == 2;
    if (images && (!arguments->pairs.empty() || !arguments->output.empty())) {
      throw CLI::ValidationError("two images take neither --pairs nor --output, expected --draw");
    }
    if (!images && (arguments->pairs.empty() || arguments->output.empty())) {
      throw CLI::ValidationError(
          "of one INPUT, a features file, --pairs and --output are expected, too");
    }
    if (images) {
      MatchImages(*arguments);
    } else {
      MatchFile(*arguments);
    }
  });
}

}  // namespace gluevo::apps
