// What becomes of a run in which some frames show nothing: each fault is put into a sequence, and
// the result held against that of the same sequence without these frames.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "gluevo/vo/pipeline/presets.h"
#include "spoil.h"

namespace gluevo::robustness {
namespace {

struct Arguments {
  std::filesystem::path dataset;
  std::vector<std::string> methods = {"klt", "superpoint", "superglue"};
  std::string features = "superpoint";
  std::vector<std::string> cases;
  int frames = 60;
  int stride = 1;
  double factor = 2.0;
  double slack_m = 0.005;
  std::optional<double> max_predicted_s;
};

// Around the middle of the sequence.
std::vector<Case> AllCases(int middle) {
  constexpr std::array<bool, 2> kBoth = {true, true};
  constexpr std::array<bool, 2> kRight = {false, true};
  return {{"black", Fault::kBlack, middle},
          {"dark", Fault::kDark, middle},
          {"white", Fault::kWhite, middle},
          {"noise", Fault::kNoise, middle},
          {"blurred", Fault::kBlurred, middle, 1, kBoth, false},
          {"covered", Fault::kCovered, middle},
          {"half-covered", Fault::kHalfCovered, middle, 1, kBoth, false},
          {"torn", Fault::kTorn, middle, 1, kBoth, false},
          {"black-3", Fault::kBlack, middle - 1, 3},
          {"black-5", Fault::kBlack, middle - 2, 5},
          {"right-black-10", Fault::kBlack, middle - 5, 10, kRight, false},
          {"frozen-5", Fault::kFrozen, middle - 2, 5},
          {"frozen-20", Fault::kFrozen, middle - 5, 20}};
}

struct Outcome {
  int segments = 0;
  std::vector<bool> predicted;  // One a frame.
  vo::Trajectory trajectory;
};

Outcome RunOver(const vo::Dataset& dataset, const std::string& method, const Arguments& arguments,
                const std::vector<vo::StereoFrame>& frames) {
  vo::OdometryConfig config =
      vo::PresetConfig(vo::PresetOf(dataset.format), method, arguments.features);
  config.odometry.max_predicted_s =
      arguments.max_predicted_s.value_or(config.odometry.max_predicted_s);
  vo::Odometry odometry(dataset.rig, config);
  Outcome outcome;
  for (const vo::StereoFrame& frame : frames) {
    const vo::FrameResult result = odometry.Process(frame);
    outcome.segments = result.segment + 1;
    outcome.predicted.push_back(result.is_predicted);
    outcome.trajectory.push_back({result.timestamp_ns, result.world_from_body});
  }
  return outcome;
}

struct Errors {
  double ate_m = 0.0;
  double end_m = 0.0;  // Of the motion from the first frame to the last.
};

Errors ErrorsOf(const vo::Trajectory& trajectory, const vo::Trajectory& groundtruth) {
  const vo::Evaluation evaluation = vo::Evaluate(trajectory, groundtruth, {});
  const auto truth_at = [&](int64_t timestamp_ns) {
    return std::min_element(groundtruth.begin(), groundtruth.end(),
                            [&](const vo::StampedPose& a, const vo::StampedPose& b) {
                              return std::abs(a.timestamp_ns - timestamp_ns) <
                                     std::abs(b.timestamp_ns - timestamp_ns);
                            })
        ->world_from_body;
  };
  const vo::Rigid3 estimated =
      trajectory.front().world_from_body.Inverse() * trajectory.back().world_from_body;
  const vo::Rigid3 expected = truth_at(trajectory.front().timestamp_ns).Inverse() *
                              truth_at(trajectory.back().timestamp_ns);
  return {evaluation.ate_se3_m, (estimated.translation - expected.translation).norm()};
}

template <typename T>
std::vector<T> WithoutSpoiled(const std::vector<T>& values, const Case& spoiled) {
  std::vector<T> kept;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!IsSpoiled(spoiled, i)) {
      kept.push_back(values[i]);
    }
  }
  return kept;
}

class Table {
 public:
  Table(const vo::Dataset& dataset, std::vector<vo::StereoFrame> frames, const Arguments& arguments)
      : dataset_(dataset), frames_(std::move(frames)), arguments_(arguments) {
    std::printf("%-11s %-15s %8s %9s %18s %18s\n", "method", "fault", "segments", "predicted",
                "ATE / without, m", "end / without, m");
  }

  // False where a bar is missed.
  bool Row(const std::string& method, const Case& spoiled) {
    const Outcome outcome = RunOver(dataset_, method, arguments_, Spoil(frames_, spoiled));
    const vo::Trajectory& groundtruth = *dataset_.groundtruth;
    const Errors errors = ErrorsOf(WithoutSpoiled(outcome.trajectory, spoiled), groundtruth);
    const Errors without = Without(method, spoiled);
    int predicted = 0;
    int predicted_others = 0;
    for (std::size_t i = 0; i < outcome.predicted.size(); ++i) {
      if (outcome.predicted[i]) {
        ++(IsSpoiled(spoiled, i) ? predicted : predicted_others);
      }
    }
    const auto meets = [&](double error, double reference) {
      return error <= arguments_.factor * reference + arguments_.slack_m;
    };
    std::string missed;
    missed += outcome.segments == 1 ? "" : " segments";
    missed += meets(errors.ate_m, without.ate_m) ? "" : " ATE";
    missed += meets(errors.end_m, without.end_m) ? "" : " end";
    missed += !spoiled.shows_nothing || predicted == spoiled.count ? "" : " predicted";
    missed += predicted_others == 0 ? "" : " predicted-others";
    std::printf("%-11s %-15s %8d %3d of %2d %8.4f / %7.4f %8.4f / %7.4f%s%s\n", method.c_str(),
                spoiled.name.c_str(), outcome.segments, predicted, spoiled.count, errors.ate_m,
                without.ate_m, errors.end_m, without.end_m,
                missed.empty() ? "" : "  MISSED:", missed.c_str());
    std::fflush(stdout);
    return missed.empty();
  }

 private:
  Errors Without(const std::string& method, const Case& spoiled) {
    const auto key = std::make_pair(method, std::make_pair(spoiled.first, spoiled.count));
    const auto known = without_.find(key);
    if (known != without_.end()) {
      return known->second;
    }
    const Outcome outcome = RunOver(dataset_, method, arguments_, WithoutSpoiled(frames_, spoiled));
    return without_[key] = ErrorsOf(outcome.trajectory, *dataset_.groundtruth);
  }

  const vo::Dataset& dataset_;
  std::vector<vo::StereoFrame> frames_;
  const Arguments& arguments_;
  std::map<std::pair<std::string, std::pair<int, int>>, Errors> without_;
};

bool IsAsked(const Arguments& arguments, const Case& spoiled) {
  return arguments.cases.empty() ||
         std::count(arguments.cases.begin(), arguments.cases.end(), spoiled.name) > 0;
}

bool Run(const Arguments& arguments) {
  vo::DatasetOptions options;
  options.count = arguments.frames;
  options.stride = arguments.stride;
  const vo::Dataset dataset = vo::OpenDataset(arguments.dataset, options);
  if (!dataset.groundtruth) {
    throw Error(arguments.dataset.string() + ": no ground truth, which errors are measured by");
  }
  std::vector<vo::StereoFrame> frames;
  frames.reserve(dataset.entries.size());
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    frames.push_back(dataset.Read(i));
  }
  const std::vector<Case> cases = AllCases(static_cast<int>(frames.size()) / 2);
  for (const std::string& name : arguments.cases) {
    if (std::none_of(cases.begin(), cases.end(), [&](const Case& c) { return c.name == name; })) {
      throw Error("no fault is called " + Quoted(name));
    }
  }
  for (const Case& spoiled : cases) {
    const int last = spoiled.first + spoiled.count;
    if (IsAsked(arguments, spoiled) &&
        (spoiled.first < 1 || last >= static_cast<int>(frames.size()))) {
      throw Error(arguments.dataset.string() + ": too few frames for the fault " +
                  Quoted(spoiled.name) + ", which needs those up to number " +
                  std::to_string(last));
    }
  }
  Table table(dataset, std::move(frames), arguments);
  bool is_good = true;
  for (const std::string& method : arguments.methods) {
    for (const Case& spoiled : cases) {
      if (IsAsked(arguments, spoiled)) {
        is_good = table.Row(method, spoiled) && is_good;
      }
    }
  }
  return is_good;
}

}  // namespace
}  // namespace gluevo::robustness

int main(int argc, char** argv) {
  gluevo::robustness::Arguments arguments;
  CLI::App app("Puts frames that show nothing into a sequence and tells what they do to the path");
  app.add_option("DATASET", arguments.dataset, "Data set with ground truth")->required();
  app.add_option("--methods", arguments.methods)->delimiter(',')->capture_default_str();
  app.add_option("--features", arguments.features, "As for gluevo run")->capture_default_str();
  app.add_option("--faults", arguments.cases, "Default: all")->delimiter(',');
  app.add_option("--frames", arguments.frames)->capture_default_str();
  app.add_option("--stride", arguments.stride)->capture_default_str();
  app.add_option("--factor", arguments.factor, "Errors may be so many times those without")
      ->capture_default_str();
  app.add_option("--max-predicted", arguments.max_predicted_s, "As for gluevo run");
  app.add_option("--slack", arguments.slack_m, "... and so much more, metres")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    return gluevo::robustness::Run(arguments) ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
}
