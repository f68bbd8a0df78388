// gluevo evaluate: how far an estimated trajectory is from ground truth.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "evaluation_json.h"
#include "evaluation_text.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/evaluation/segment_evaluation.h"
#include "gluevo/vo/evaluation/time_scale.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "json_text.h"
#include "segments_file.h"
#include "trajectory_lines.h"
#include "trajectory_plot.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct EvaluateArguments {
  fs::path estimate;
  fs::path groundtruth;
  fs::path times;
  fs::path plot;
  fs::path segments;  // metrics.json; empty for the one beside the estimate.
  bool json = false;
  vo::EvaluationOptions options;
};

// What belongs to an estimate whose poses are linked within segments only.
struct Segments {
  std::vector<int> of_pose;
  vo::SegmentedEvaluation evaluation;
};

void PrintJson(const vo::Evaluation& evaluation, const std::optional<Segments>& segments,
               const std::vector<std::string>& warnings, const vo::EvaluationOptions& options) {
  nlohmann::ordered_json json;
  AddEvaluation(evaluation, json);
  json["rpe_frames"] = options.rpe_frames;
  if (segments) {
    AddSegmentedEvaluation(segments->evaluation, json);
  }
  json["warnings"] = warnings;
  std::cout << JsonText(json);
}

void PrintTable(const vo::Evaluation& evaluation, const std::optional<Segments>& segments,
                const vo::EvaluationOptions& options) {
  const RpeText rpe = TextOfRpe(evaluation, 6, 6);
  std::cout << std::fixed << std::setprecision(6)  //
            << "associated poses            " << evaluation.pairs << " of "
            << std::min(evaluation.estimate_poses, evaluation.groundtruth_poses) << '\n'
            << "ATE, SE(3) aligned          " << evaluation.ate_se3_m << " m\n"
            << "ATE, Sim(3) aligned         " << evaluation.ate_sim3_m << " m\n"
            << "scale                       " << TextOfScale(evaluation, 6) << '\n'
            << "RPE, translation            " << rpe.translation << '\n'
            << "RPE, rotation               " << rpe.rotation << '\n'
            << "RPE, lengths                " << TextOfRpeLengths(evaluation) << '\n'
            << "RPE over " << std::left << std::setw(19) << vo::Counted(options.rpe_frames, "frame")
            << TextOfRpeOverFrames(evaluation, 6) << '\n'
            << "correct motions             " << evaluation.correct_motions << " of "
            << evaluation.pairs - 1 << '\n'
            << "coverage of the time        " << 100.0 * evaluation.coverage << " %\n";
  if (!segments || segments->evaluation.segments.size() < 2) {
    return;
  }
  const vo::SegmentedEvaluation& segmented = segments->evaluation;
  std::cout << "segments                    " << segmented.segments.size() << ", "
            << vo::Counted(segmented.breaks, "declared break") << "\n"
            << "ATE within segments         " << segmented.ate_within_segments_m << " m, over "
            << vo::Counted(segmented.pairs_within_segments, "pose") << "\n"
            << "correct within segments     " << segmented.correct_motions << " of "
            << segmented.motions << '\n';
  for (const vo::SegmentedEvaluation::Segment& segment : segmented.segments) {
    std::cout << "  segment " << std::setw(18) << segment.number
              << vo::Counted(segment.pairs, "pose");
    if (segment.evaluation) {
      std::cout << ", ATE " << segment.evaluation->ate_se3_m << " m";
    }
    std::cout << '\n';
  }
}

// The segments that the metrics.json named, or beside the estimate, declares.
std::optional<Segments> FindSegments(const EvaluateArguments& arguments,
                                     const vo::Trajectory& estimate,
                                     const vo::Trajectory& groundtruth) {
  const fs::path beside = arguments.estimate.parent_path() / "metrics.json";
  const bool is_named = !arguments.segments.empty();
  if (!is_named && !fs::exists(beside)) {
    return std::nullopt;
  }
  Segments segments;
  try {
    segments.of_pose = ReadSegments(is_named ? arguments.segments : beside, estimate);
  } catch (const Error& error) {
    if (is_named) {
      throw;
    }
    PrintMessage("gluevo: note", std::string("segments not used: ") + error.what());
    return std::nullopt;
  }
  segments.evaluation =
      vo::EvaluateSegments(estimate, segments.of_pose, groundtruth, arguments.options);
  return segments;
}

void Plot(const fs::path& path, const vo::Trajectory& estimate, const vo::Trajectory& groundtruth,
          const vo::Evaluation& evaluation, const std::optional<Segments>& segments) {
  std::ostringstream caption;
  caption << std::fixed << std::setprecision(4);
  if (segments && segments->evaluation.segments.size() > 1) {
    caption << "ATE within segments " << segments->evaluation.ate_within_segments_m << " m";
    WriteTrajectoryPlot(
        path, AlignSegments(estimate, segments->of_pose, groundtruth, segments->evaluation),
        caption.str());
    return;
  }
  caption << "ATE " << evaluation.ate_se3_m << " m (SE3), " << evaluation.ate_sim3_m << " m (Sim3)";
  WriteTrajectoryPlot(path, AlignWhole(estimate, groundtruth, evaluation), caption.str());
}

// Both trajectories, and what is to be known of how they were read.
struct Inputs {
  vo::Trajectory estimate;
  vo::Trajectory groundtruth;
  std::vector<std::string> warnings;
};

// Two KITTI files without times are of the same frames, by their numbers or row by row.
void CheckRowsBelongTogether(const EvaluateArguments& arguments, const vo::TrajectoryFile& estimate,
                             const vo::TrajectoryFile& groundtruth) {
  const std::string first = arguments.estimate.string();
  const std::string second = arguments.groundtruth.string();
  if (estimate.is_numbered != groundtruth.is_numbered) {
    throw Error((estimate.is_numbered ? first : second) + " has the numbers of its frames and " +
                (estimate.is_numbered ? second : first) +
                " has none: which of its rows belong to them is not known; name the times of both "
                "with --times, or number both");
  }
  if (!estimate.is_numbered && estimate.rows != groundtruth.rows) {
    throw Error(first + " has " + vo::Counted(estimate.rows, "pose") + " and " + second + " " +
                std::to_string(groundtruth.rows) +
                ": KITTI files without times belong together row by row");
  }
}

// Where one file counts, say, milliseconds and nothing in it tells so.
void BringTimesTogether(const EvaluateArguments& arguments, Inputs& inputs) {
  const std::optional<vo::TimeScale> scale =
      vo::FindTimeScale(inputs.estimate, inputs.groundtruth, arguments.options);
  if (!scale) {
    return;
  }
  vo::ScaleTimes(scale->power_of_ten, scale->of_estimate ? inputs.estimate : inputs.groundtruth);
  const fs::path& path = scale->of_estimate ? arguments.estimate : arguments.groundtruth;
  inputs.warnings.push_back(path.string() + ": its times are multiplied by 10^" +
                            std::to_string(scale->power_of_ten) +
                            ": they are in another unit than those of the other file");
}

// Each is read once: it may be a pipe.
Inputs ReadInputs(const EvaluateArguments& arguments) {
  vo::TrajectoryFile estimate = vo::ReadTrajectoryFile(arguments.estimate);
  vo::TrajectoryFile groundtruth = vo::ReadTrajectoryFile(arguments.groundtruth);
  const std::optional<fs::path> times =
      arguments.times.empty() ? std::nullopt : std::optional(arguments.times);
  const bool have_times = times || estimate.format != vo::TrajectoryFormat::kKitti ||
                          groundtruth.format != vo::TrajectoryFormat::kKitti;
  if (!have_times) {
    CheckRowsBelongTogether(arguments, estimate, groundtruth);
  }
  Inputs inputs;
  for (const auto& [path, file] : {std::pair{&arguments.estimate, &estimate},
                                   std::pair{&arguments.groundtruth, &groundtruth}}) {
    if (have_times) {
      vo::AddRowTimes(*path, times, *file);
    }
    for (const std::string& note : file->notes) {
      inputs.warnings.push_back(path->string() + ": " + note);
    }
  }
  inputs.estimate = std::move(estimate.poses);
  inputs.groundtruth = std::move(groundtruth.poses);
  BringTimesTogether(arguments, inputs);
  return inputs;
}

void Evaluate(const EvaluateArguments& arguments) {
  if (!arguments.plot.empty()) {
    CheckOutputsAreNoInputs({arguments.plot}, {arguments.estimate, arguments.groundtruth,
                                               arguments.times, arguments.segments});
    // The segments and times that are found by themselves are none either.
    nn::CheckReplacesOnly(arguments.plot, "<svg ", "an SVG file");
    nn::CheckPlaceForFile(arguments.plot);
  }
  Inputs inputs = ReadInputs(arguments);
  const vo::Trajectory& estimate = inputs.estimate;
  const vo::Trajectory& groundtruth = inputs.groundtruth;
  // An input that was read in an unusual way may be why the evaluation fails: said before.
  for (const std::string& warning : inputs.warnings) {
    PrintMessage("gluevo: note", warning);
  }
  const vo::Evaluation evaluation = vo::Evaluate(estimate, groundtruth, arguments.options);
  const std::optional<Segments> segments = FindSegments(arguments, estimate, groundtruth);
  if (!arguments.plot.empty()) {
    Plot(arguments.plot, estimate, groundtruth, evaluation, segments);
  }
  for (const auto& warning :
       {vo::AssociationWarning(evaluation, arguments.options), vo::ScaleWarning(evaluation)}) {
    if (warning) {
      PrintMessage("gluevo: warning", *warning);
      inputs.warnings.push_back(*warning);
    }
  }
  if (arguments.json) {
    PrintJson(evaluation, segments, inputs.warnings, arguments.options);
  } else {
    PrintTable(evaluation, segments, arguments.options);
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
      ->check(Within(0.0, 1e6))
      ->capture_default_str();
  command
      ->add_option("--delta", arguments->options.rpe_frames,
                   "Frames of the relative pose error over frames")
      ->check(AtLeast(1))
      ->capture_default_str();
  command->add_flag("--all-pairs", arguments->options.rpe_every_frame,
                    "Take it from every frame, not from every so many-th");
  command
      ->add_option("--rpe-lengths", arguments->options.rpe_lengths_m,
                   "Lengths of the sub-paths of the relative pose error, metres, by commas; "
                   "default: KITTI's, shorter where the path is short")
      ->delimiter(',')
      ->check(Above(0.0));
  command->add_option("--segments", arguments->segments,
                      "metrics.json of the run, whose segments are also evaluated each on its own; "
                      "default: the one beside ESTIMATE");
  command->add_option("--plot", arguments->plot, "SVG file to draw both trajectories to");
  command->add_flag("--json", arguments->json, "Print JSON instead of a table");
  command->footer(
      "Example:\n  gluevo evaluate results/trajectory.tum groundtruth.csv --plot plot.svg");
  command->callback([arguments] { Evaluate(*arguments); });
}

}  // namespace gluevo::apps
