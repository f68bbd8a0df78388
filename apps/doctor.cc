// gluevo doctor: what is good, suspicious and wrong with a data set, without running it.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/doctor/doctor.h"
#include "options/dataset_options.h"

namespace gluevo::apps {
namespace {

struct DoctorArguments {
  std::filesystem::path dataset;
  DatasetArguments frames;
  vo::DoctorOptions options;
  bool json = false;
};

void PrintFindings(const vo::Diagnosis& diagnosis) {
  std::size_t topic_width = 0;
  for (const vo::Finding& finding : diagnosis.findings) {
    topic_width = std::max(topic_width, finding.topic.size());
  }
  for (const vo::Finding& finding : diagnosis.findings) {
    std::cout << std::left << std::setw(12) << vo::NameOf(finding.verdict)
              << std::setw(static_cast<int>(topic_width) + 2) << finding.topic
              << OneLine(finding.value);
    if (finding.verdict != vo::Verdict::kGood && !finding.expected.empty()) {
      std::cout << " (expected: " << finding.expected << ")";
    }
    std::cout << '\n';
  }
  std::cout << diagnosis.Count(vo::Verdict::kGood) << " good, "
            << diagnosis.Count(vo::Verdict::kSuspicious) << " suspicious, "
            << diagnosis.Count(vo::Verdict::kWrong) << " wrong\n";
}

void PrintFindingsJson(const vo::Diagnosis& diagnosis) {
  nlohmann::ordered_json json;
  json["good"] = diagnosis.Count(vo::Verdict::kGood);
  json["suspicious"] = diagnosis.Count(vo::Verdict::kSuspicious);
  json["wrong"] = diagnosis.Count(vo::Verdict::kWrong);
  json["findings"] = nlohmann::ordered_json::array();
  for (const vo::Finding& finding : diagnosis.findings) {
    json["findings"].push_back({{"verdict", vo::NameOf(finding.verdict)},
                                {"topic", finding.topic},
                                {"value", finding.value},
                                {"expected", finding.expected}});
  }
  // Names of files need not be UTF-8.
  std::cout << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
}

}  // namespace

void AddDoctorCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "doctor", "Look at a data set without running it: what is good, suspicious, wrong");
  const auto arguments = std::make_shared<DoctorArguments>();
  command->add_option("DATASET", arguments->dataset, "Folder of the data set")->required();
  AddDatasetOptions(*command, arguments->frames);
  command
      ->add_option("--pairs", arguments->options.pairs,
                   "Stereo pairs to look at, evenly over the frames, at most")
      ->check(AtLeast(1))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print JSON instead of a page");
  command->footer(
      "Exit code 0 where nothing is wrong, 1 where something is.\nExample:\n  gluevo doctor "
      "data/mine --calibration stereo.yaml");
  command->callback([arguments] {
    const vo::Diagnosis diagnosis =
        vo::Examine(arguments->dataset, MakeDatasetOptions(arguments->frames), arguments->options);
    if (arguments->json) {
      PrintFindingsJson(diagnosis);
    } else {
      PrintFindings(diagnosis);
    }
    const std::size_t wrong = diagnosis.Count(vo::Verdict::kWrong);
    if (wrong > 0) {
      throw Error(arguments->dataset.string() + ": " + std::to_string(wrong) +
                  (wrong == 1 ? " thing is wrong" : " things are wrong"));
    }
  });
}

}  // namespace gluevo::apps
