// gluevo extract: SuperPoint over a folder of images.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>

#include "commands.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/frontend/feature_files.h"
#include "image_files.h"
#include "interruption.h"
#include "options/network_options.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct ExtractArguments {
  fs::path images;
  fs::path output;
  vo::NetworkFiles networks;
  int threads = 0;
  nn::SuperPointOptions superpoint;
};

void Extract(const ExtractArguments& arguments) {
  const Interruption interruption;
  const std::vector<fs::path> images = ListImagesBelow(arguments.images);
  nn::ThreadPool pool(arguments.threads);
  const vo::Networks networks = vo::LoadNetworks(arguments.networks, /*with_superglue=*/false);
  const std::unique_ptr<vo::FeatureExtractor> extractor =
      vo::MakeExtractor(networks, arguments.superpoint, pool);

  vo::FeatureWriter writer(arguments.output);
  std::size_t keypoints = 0;
  {
    Progress progress("image", images.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
      // A file that lacks images would pass for a whole one: what is done is given up.
      Interruption::Check();
      const nn::Features features = extractor->Extract(ReadGrayImage(images[i]));
      writer.Add(fs::relative(images[i], arguments.images).generic_string(), features);
      keypoints += static_cast<std::size_t>(features.size());
      progress.Update(i + 1, std::to_string(features.size()) + " keypoints");
    }
  }
  writer.Finish();
  std::cout << images.size() << " images, " << keypoints
            << " keypoints: " << arguments.output.string() << '\n';
}

}  // namespace

void AddExtractCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "extract", "SuperPoint over all images below a folder, into an HDF5 file (hloc's layout)");
  const auto arguments = std::make_shared<ExtractArguments>();
  command
      ->add_option("IMAGES", arguments->images,
                   "Folder of images or data set; an image's name is its path below it")
      ->required();
  command->add_option("-o,--output", arguments->output, "HDF5 file to write")->required();
  AddSuperPointOptions(*command, arguments->superpoint);
  AddNetworkOptions(*command, arguments->networks, arguments->threads);
  command->footer("Example:\n  gluevo extract images/ -o features.h5 --max-keypoints 2048");
  command->callback([arguments] { Extract(*arguments); });
}

}  // namespace gluevo::apps
