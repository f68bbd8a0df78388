// gluevo codebook: typical descriptors of a network, by which places are recognised.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/io/image_file.h"
#include "gluevo/vo/mapping/place_training.h"
#include "interruption.h"
#include "named_extraction.h"
#include "options/network_options.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct CodebookArguments {
  fs::path images;
  fs::path output;
  std::string features = "superpoint";
  vo::NetworkFiles networks;
  int threads = 0;
  vo::PlaceTrainingOptions training;
};

std::vector<nn::Features> DescribeAll(const std::vector<fs::path>& images,
                                      vo::FeatureExtractor& extractor) {
  const int gray_bits = vo::GrayBits(images);
  std::vector<nn::Features> described;
  described.reserve(images.size());
  Progress progress("image", images.size());
  for (const fs::path& image : images) {
    Interruption::Check();
    described.push_back(ExtractNamed(extractor, vo::ReadGrayImage(image, gray_bits).pixels, image));
    progress.Update(described.size(), std::to_string(described.back().size()) + " keypoints");
  }
  return described;
}

void MakeCodebook(const CodebookArguments& arguments) {
  const Interruption interruption;
  arguments.training.Validate();
  std::vector<fs::path> inputs = WeightsInputs(arguments.networks);
  inputs.push_back(arguments.images);
  CheckOutputsAreNoInputs({arguments.output}, inputs);
  nn::CheckReplacesOnly(arguments.output, "\"centres\"", "a place codebook");
  const std::vector<fs::path> images = vo::ListImagesBelow(arguments.images);
  nn::ThreadPool pool(arguments.threads);
  const vo::Networks networks = vo::LoadNetworks(arguments.networks, arguments.features, "");
  const std::unique_ptr<vo::FeatureExtractor> extractor = vo::MakeExtractor(
      networks,
      {.keypoint_threshold = vo::UsualKeypointThreshold(arguments.features), .max_keypoints = 500},
      pool);
  const vo::PlaceCodebook codebook = vo::TrainPlaceCodebook(
      DescribeAll(images, *extractor), networks.records.front().checksum, arguments.training);
  vo::WritePlaceCodebook(arguments.output, codebook);
  std::cout << vo::Counted(images.size(), "image") << ", "
            << vo::Counted(codebook.centres().rows(), "centre") << " of "
            << codebook.descriptor_size() << " values: " << OneLine(arguments.output.string())
            << '\n';
}

}  // namespace

void AddCodebookCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "codebook",
      "Typical descriptors of a network, from images of many places, for run's --codebook");
  const auto arguments = std::make_shared<CodebookArguments>();
  command->add_option("IMAGES", arguments->images, "Folder of images")->required();
  command->add_option("-o,--output", arguments->output, "Safetensors file to write")->required();
  command->add_option("--centres", arguments->training.centres, "How many")
      ->capture_default_str()
      ->check(Within(1, 4096));
  AddFeaturesOption(*command, arguments->features);
  AddNetworkOptions(*command, arguments->networks, arguments->threads);
  command->footer("Example:\n  gluevo codebook images/ --weights weights/ -o places.safetensors");
  command->callback([arguments] { MakeCodebook(*arguments); });
}

}  // namespace gluevo::apps
