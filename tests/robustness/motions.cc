// How right the motions of runs are, frame by frame, and which of the wrong ones were declared
// (lost, predicted, doubtful): for sequences with things that move, held against the first one.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/median.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "gluevo/vo/pipeline/presets.h"

namespace gluevo::robustness {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::vector<fs::path> datasets;
  std::vector<std::string> methods = {"klt", "superglue"};
  fs::path matches;
  int count = -1;
  int stride = 1;
  double factor = 1.5;
  double wrong_m = 0.1;
  bool lists = false;
  vo::OdometryOptions trial;
};

struct Run {
  std::vector<vo::FrameResult> frames;
  vo::Trajectory trajectory;
};

vo::Dataset Open(const Arguments& arguments, const fs::path& path) {
  vo::DatasetOptions options;
  options.count = arguments.count;
  options.stride = arguments.stride;
  if (fs::exists(path / "groundtruth.tum")) {
    options.groundtruth = path / "groundtruth.tum";
  }
  vo::Dataset dataset = vo::OpenDataset(path, options);
  if (!dataset.groundtruth) {
    throw Error(path.string() + ": no ground truth, which errors are measured by");
  }
  return dataset;
}

std::vector<int64_t> TimesOf(const vo::Dataset& dataset) {
  std::vector<int64_t> times;
  times.reserve(dataset.entries.size());
  for (const vo::Dataset::Entry& entry : dataset.entries) {
    times.push_back(entry.timestamp_ns);
  }
  return times;
}

// With --matches the networks run once for a data set and a method.
Run RunOver(const Arguments& arguments, const vo::Dataset& dataset, const std::string& method) {
  vo::OdometryConfig config = vo::PresetConfig(vo::PresetOf(dataset.format), method);
  config.odometry.votes = arguments.trial.votes;
  config.odometry.max_predicted_s = arguments.trial.max_predicted_s;
  const fs::path store = arguments.matches / (dataset.root.filename().string() + "_" + method +
                                              "_" + std::to_string(arguments.stride) + ".h5");
  const bool is_replay = !arguments.matches.empty() && fs::exists(store);
  std::optional<vo::Odometry> odometry;
  std::optional<vo::MatchStoreWriter> writer;
  if (is_replay) {
    odometry.emplace(dataset.rig,
                     std::make_unique<vo::ReplayFrontEnd>(vo::MatchStoreReader(store), dataset.rig,
                                                          TimesOf(dataset)),
                     config.odometry);
  } else {
    odometry.emplace(dataset.rig, config);
    if (!arguments.matches.empty()) {
      writer.emplace(store, dataset.rig, vo::RunRecord{method, {}, {}});
    }
  }
  Run run;
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    run.frames.push_back(odometry->Process(
        is_replay ? vo::StereoFrame{dataset.entries[i].timestamp_ns, {}} : dataset.Read(i)));
    if (writer) {
      writer->Add(run.frames.back().tracked_frame);
    }
    run.frames.back().tracked_frame = {};
    run.trajectory.push_back({run.frames.back().timestamp_ns, run.frames.back().world_from_body});
  }
  if (writer) {
    writer->Finish();
  }
  return run;
}

bool IsDeclared(const Run& run, std::size_t frame) {
  const vo::FrameResult& now = run.frames[frame];
  const vo::FrameResult& before = run.frames[frame - 1];
  return now.segment != before.segment || now.is_predicted || now.is_doubtful ||
         before.is_predicted || before.is_doubtful;
}

// Squared error of a frame's motion since its key frame, in standard deviations, a degree of
// freedom; nothing where the truth of one is missing.
std::optional<double> SquaredError(const Run& run, std::size_t frame,
                                   const vo::Trajectory& groundtruth) {
  const vo::FrameResult& to = run.frames[frame];
  const auto truth_at = [&](int64_t timestamp_ns) {
    constexpr int64_t kNearNs = 10'000'000;
    const auto next = std::lower_bound(
        groundtruth.begin(), groundtruth.end(), timestamp_ns - kNearNs,
        [](const vo::StampedPose& pose, int64_t time) { return pose.timestamp_ns < time; });
    auto best = groundtruth.end();
    for (auto it = next; it != groundtruth.end() && it->timestamp_ns <= timestamp_ns + kNearNs;
         ++it) {
      if (best == groundtruth.end() ||
          std::abs(it->timestamp_ns - timestamp_ns) < std::abs(best->timestamp_ns - timestamp_ns)) {
        best = it;
      }
    }
    return best;
  };
  const auto truth_from = truth_at(to.motion_from_ns);
  const auto truth_to = truth_at(to.timestamp_ns);
  if (truth_from == groundtruth.end() || truth_to == groundtruth.end() || to.is_predicted ||
      to.motion_from_ns == to.timestamp_ns) {
    return std::nullopt;
  }
  const Eigen::Matrix<double, 6, 1> error = vo::ErrorOfPose(
      to.keyframe_from_body, truth_from->world_from_body.Inverse() * truth_to->world_from_body);
  return error.dot(to.motion_covariance.ldlt().solve(error)) / 6.0;
}

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

struct Row {
  double ate_m = 0.0;
  int undeclared = 0;
};

Row Print(const Arguments& arguments, const vo::Dataset& dataset, const std::string& method) {
  const Run run = RunOver(arguments, dataset, method);
  const vo::Evaluation evaluation = vo::Evaluate(run.trajectory, *dataset.groundtruth, {});
  Row row{evaluation.ate_se3_m};
  std::vector<double> motions;
  std::vector<double> squares;  // Of errors of located motions, in standard deviations.
  double worst = 0.0;
  int declared = 0, predicted = 0, doubtful = 0, moving = 0;
  std::size_t frame = 0;
  for (std::size_t i = 1; i < evaluation.errors.size(); ++i) {
    const vo::PoseError& error = evaluation.errors[i];
    while (run.frames[frame].timestamp_ns != error.timestamp_ns) {
      ++frame;
    }
    motions.push_back(error.motion_m);
    const bool is_declared = IsDeclared(run, frame);
    if (error.motion_m > arguments.wrong_m) {
      ++(is_declared ? declared : row.undeclared);
      if (arguments.lists) {
        std::printf("    frame %zu: %.3f m wrong%s\n", frame, error.motion_m,
                    is_declared ? ", declared" : "");
      }
    }
    worst = is_declared ? worst : std::max(worst, error.motion_m);
  }
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    if (const auto square = SquaredError(run, i, *dataset.groundtruth)) {
      squares.push_back(*square);
      constexpr double kMuch = 5.0;
      if (arguments.lists && *square > kMuch) {
        std::printf("    frame %zu: squared error %.1f times the variance\n", i, *square);
      }
    }
  }
  for (const vo::FrameResult& result : run.frames) {
    predicted += result.is_predicted ? 1 : 0;
    doubtful += result.is_doubtful ? 1 : 0;
    moving += result.moving;
  }
  std::printf(
      "%-24s %-10s %4zu %4d %5d %5d %6.1f %8.4f %8.4f %7.3f %8.4f %8.4f %8.3f %5d %5d %6.2f "
      "%6.2f\n",
      dataset.root.filename().c_str(), method.c_str(), run.frames.size(),
      run.frames.back().segment + 1, predicted, doubtful,
      static_cast<double>(moving) / static_cast<double>(run.frames.size()), evaluation.ate_se3_m,
      evaluation.scale, evaluation.rpe_translation_percent, evaluation.rpe_rotation_deg_per_m,
      vo::Median(motions), worst, row.undeclared, declared, Mean(squares), vo::Median(squares));
  std::fflush(stdout);
  return row;
}

bool Compare(const Arguments& arguments) {
  std::printf("%-24s %-10s %4s %4s %5s %5s %6s %8s %8s %7s %8s %8s %8s %5s %5s %6s %6s\n",
              "data set", "method", "n", "segm", "pred", "doubt", "moving", "ATE, m", "scale",
              "RPE, %", "deg/m", "median", "worst", "wrong", "decl.", "NEES", "median");
  bool is_good = true;
  for (const std::string& method : arguments.methods) {
    double reference = 0.0;
    for (const fs::path& path : arguments.datasets) {
      const Row row = Print(arguments, Open(arguments, path), method);
      reference = reference > 0.0 ? reference : row.ate_m;
      is_good = is_good && row.undeclared == 0 && row.ate_m <= arguments.factor * reference;
    }
  }
  return is_good;
}

}  // namespace
}  // namespace gluevo::robustness

int main(int argc, char** argv) {
  gluevo::robustness::Arguments arguments;
  CLI::App app("How right each motion is, and what of the wrong ones was declared");
  app.add_option("DATASETS", arguments.datasets, "The first is what the others are held against")
      ->required();
  app.add_option("--methods", arguments.methods)->delimiter(',')->capture_default_str();
  app.add_option("--matches", arguments.matches, "Folder that keeps matches for the next time");
  app.add_option("--count", arguments.count)->capture_default_str();
  app.add_option("--stride", arguments.stride)->capture_default_str();
  app.add_option("--factor", arguments.factor, "The ATE may be so many times the first one's")
      ->capture_default_str();
  app.add_option("--wrong", arguments.wrong_m, "A motion is wrong by more than this, metres")
      ->capture_default_str();
  app.add_flag("--list", arguments.lists, "Name the wrong motions");
  auto& trial = arguments.trial;
  app.add_option("--max-predicted", trial.max_predicted_s)->capture_default_str();
  app.add_option("--new-vote", trial.votes.new_vote)->capture_default_str();
  app.add_option("--full-after", trial.votes.full_after)->capture_default_str();
  app.add_option("--cell-limit", trial.votes.cell_limit)->capture_default_str();
  app.add_option("--strikes", trial.votes.strikes)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    return gluevo::robustness::Compare(arguments) ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
}
