// gluevo extract: SuperPoint or ALIKED over a folder of images.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/frontend/feature_files.h"
#include "gluevo/vo/io/image_file.h"
#include "interruption.h"
#include "named_extraction.h"
#include "options/network_options.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct ExtractArguments {
  fs::path images;
  fs::path output;
  std::string features = "superpoint";
  vo::NetworkFiles networks;
  int threads = 0;
  std::optional<float> keypoint_threshold;  // What suits the features where it is not given.
  int max_keypoints = 1024;
};

// What a user should know about images, said once for each kind.
struct Remarks {
  std::size_t left_out = 0;
  std::size_t turned = 0;
  fs::path first_turned;
};

// Nothing for an image that cannot be read or is too small, which is named.
std::optional<nn::Features> ExtractOrLeaveOut(const fs::path& file, int gray_bits,
                                              vo::FeatureExtractor& extractor, Remarks& remarks) {
  try {
    const vo::GrayImage image = vo::ReadGrayImage(file, gray_bits);
    nn::Features features = ExtractNamed(extractor, image.pixels, file);
    if (image.orientation != 1 && ++remarks.turned == 1) {
      remarks.first_turned = file;
    }
    return features;
  } catch (const Error& error) {
    ++remarks.left_out;
    PrintMessage("gluevo: warning", std::string(error.what()) + "; it is left out");
    return std::nullopt;
  }
}

void Report(const Remarks& remarks) {
  if (remarks.turned > 0) {
    PrintMessage("gluevo: note", vo::Counted(remarks.turned, "image asks", "images ask") +
                                     " to be turned (EXIF), which is never done: the first is " +
                                     remarks.first_turned.string());
  }
}

void Extract(const ExtractArguments& arguments) {
  const Interruption interruption;
  std::vector<fs::path> inputs = WeightsInputs(arguments.networks);
  inputs.push_back(arguments.images);
  CheckOutputsAreNoInputs({arguments.output}, inputs);
  nn::CheckReplacesOnly(arguments.output, nn::kHdf5Mark, "an HDF5 file");
  const std::vector<fs::path> images = vo::ListImagesBelow(arguments.images);
  const int gray_bits = vo::GrayBits(images);
  nn::ThreadPool pool(arguments.threads);
  const vo::Networks networks = vo::LoadNetworks(arguments.networks, arguments.features, "");
  const std::unique_ptr<vo::FeatureExtractor> extractor = vo::MakeExtractor(
      networks,
      {.keypoint_threshold =
           arguments.keypoint_threshold.value_or(vo::UsualKeypointThreshold(arguments.features)),
       .max_keypoints = arguments.max_keypoints},
      pool);

  vo::FeatureWriter writer(arguments.output);
  std::size_t keypoints = 0;
  Remarks remarks;
  {
    Progress progress("image", images.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
      // A file that lacks images would pass for a whole one: what is done is given up.
      Interruption::Check();
      const std::optional<nn::Features> features =
          ExtractOrLeaveOut(images[i], gray_bits, *extractor, remarks);
      if (!features) {
        continue;
      }
      writer.Add(images[i].lexically_relative(arguments.images).generic_string(), *features);
      keypoints += static_cast<std::size_t>(features->size());
      progress.Update(i + 1, vo::Counted(features->size(), "keypoint"));
    }
  }
  Report(remarks);
  if (remarks.left_out == images.size()) {
    throw Error(arguments.images.string() + ": none of its images can be read");
  }
  writer.Finish();
  std::cout << vo::Counted(images.size() - remarks.left_out, "image") << ", "
            << vo::Counted(keypoints, "keypoint") << ": " << OneLine(arguments.output.string())
            << '\n';
  if (remarks.left_out > 0) {
    std::cout << vo::Counted(remarks.left_out, "image") << " that cannot be read left out\n";
  }
}

}  // namespace

void AddExtractCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "extract",
      "SuperPoint or ALIKED over all images below a folder, into an HDF5 file (hloc's layout)");
  const auto arguments = std::make_shared<ExtractArguments>();
  command
      ->add_option("IMAGES", arguments->images,
                   "Folder of images or data set; an image's name is its path below it")
      ->required();
  command->add_option("-o,--output", arguments->output, "HDF5 file to write")->required();
  AddFeaturesOption(*command, arguments->features);
  AddKeypointOptions(*command, arguments->keypoint_threshold, arguments->max_keypoints);
  AddNetworkOptions(*command, arguments->networks, arguments->threads);
  command->footer("Example:\n  gluevo extract images/ -o features.h5 --max-keypoints 2048");
  command->callback([arguments] { Extract(*arguments); });
}

}  // namespace gluevo::apps
