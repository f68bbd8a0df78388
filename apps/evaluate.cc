// gluevo evaluate: how far an estimated trajectory is from ground truth.

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/evaluation.h"
#include "gluevo/vo/trajectory.h"
#include "trajectory_plot.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct EvaluateArguments {
  fs::path estimate;
  fs::path groundtruth;
  fs::path times;
  fs::path plot;
  bool json = false;
  vo::EvaluationOptions options;
};

void PrintJson(const vo::Evaluation& evaluation) {
  const auto finite = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json json;
  json["pairs"] = evaluation.pairs;
  json["ate_se3_m"] = finite(evaluation.ate_se3_m);
  json["ate_sim3_m"] = finite(evaluation.ate_sim3_m);
  json["scale"] = finite(evaluation.scale);
  json["rpe_translation_percent"] = finite(evaluation.rpe_translation_percent);
  json["rpe_rotation_deg_per_m"] = finite(evaluation.rpe_rotation_deg_per_m);
  json["rpe_lengths_m"] = evaluation.rpe_lengths_m;
  json["right_motions"] = evaluation.right_motions;
  json["coverage"] = finite(evaluation.coverage);
  std::cout << json.dump(2) << '\n';
}

void PrintTable(const vo::Evaluation& evaluation) {
  std::cout << std::fixed << std::setprecision(6)  //
            << "associated poses            " << evaluation.pairs << '\n'
            << "ATE, SE(3) aligned          " << evaluation.ate_se3_m << " m\n"
            << "ATE, Sim(3) aligned         " << evaluation.ate_sim3_m << " m\n"
            << "scale                       " << evaluation.scale << '\n'
            << "RPE, translation            " << evaluation.rpe_translation_percent << " %\n"
            << "RPE, rotation               " << evaluation.rpe_rotation_deg_per_m << " deg/m\n"
            << "right motions               " << evaluation.right_motions << " of "
            << evaluation.pairs - 1 << '\n'
            << "coverage of the time        " << 100.0 * evaluation.coverage << " %\n";
}

// Two KITTI files without times are of the same frames, row by row.
bool AssociateByRow(const EvaluateArguments& arguments) {
  return arguments.times.empty() &&
         vo::RecognizeTrajectoryFormat(arguments.estimate) == vo::TrajectoryFormat::kKitti &&
         vo::RecognizeTrajectoryFormat(arguments.groundtruth) == vo::TrajectoryFormat::kKitti;
}

void Evaluate(const EvaluateArguments& arguments) {
  const auto read = [&](const fs::path& path) {
    return vo::ReadTrajectory(
        path, arguments.times.empty() ? std::nullopt : std::optional(arguments.times));
  };
  const bool by_row = AssociateByRow(arguments);
  const vo::Trajectory estimate =
      by_row ? vo::ReadKittiTrajectoryByRow(arguments.estimate) : read(arguments.estimate);
  const vo::Trajectory groundtruth =
      by_row ? vo::ReadKittiTrajectoryByRow(arguments.groundtruth) : read(arguments.groundtruth);
  if (by_row && estimate.size() != groundtruth.size()) {
    throw Error(arguments.estimate.string() + " has " + std::to_string(estimate.size()) +
                " poses and " + arguments.groundtruth.string() + " " +
                std::to_string(groundtruth.size()) +
                ": KITTI files without times belong together row by row");
  }
  const vo::Evaluation evaluation = vo::Evaluate(estimate, groundtruth, arguments.options);
  if (!arguments.plot.empty()) {
    WriteTrajectoryPlot(arguments.plot, estimate, groundtruth, evaluation);
  }
  if (arguments.json) {
    PrintJson(evaluation);
  } else {
    PrintTable(evaluation);
  }
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "evaluate", "Compare a trajectory with ground truth: ATE, RPE, scale, coverage");
  const auto arguments = std::make_shared<EvaluateArguments>();
  command->add_option("ESTIMATE", arguments->estimate, "Trajectory: TUM, EuRoC csv or KITTI")
      ->required();
  command->add_option("GROUNDTRUTH", arguments->groundtruth, "The same of the ground truth")
      ->required();
  command->add_option("--times", arguments->times,
                      "KITTI's times.txt, for the times of a KITTI file");
  command
      ->add_option("--max-time-difference", arguments->options.max_time_difference_s,
                   "Poses at most this far apart in time belong together, seconds")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--plot", arguments->plot, "SVG file to draw both trajectories to");
  command->add_flag("--json", arguments->json, "Print JSON instead of a table");
  command->footer(
      "Example:\n  gluevo evaluate results/trajectory.tum groundtruth.csv --plot plot.svg");
  command->callback([arguments] { Evaluate(*arguments); });
}

}  // namespace gluevo::apps
