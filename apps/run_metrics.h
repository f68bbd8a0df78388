#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/evaluation/segment_evaluation.h"
#include "gluevo/vo/pipeline/networks.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "options/preset_options.h"
#include "report/run_report.h"

namespace gluevo::apps {

/// Gathers what happens to each frame of a run, and writes it as metrics.json.
class RunMetrics {
 public:
  /// What the record says beside the frames.
  struct Context {
    std::string method;
    int threads = 1;
    vo::WeightsRecord superpoint;  ///< Empty where the method has none.
    vo::WeightsRecord superglue;
    std::map<std::string, std::string> options;
    OptionOrigins origins;
    std::vector<std::string> dataset_warnings;  ///< vo::Dataset's.
    int images_left_out = 0;
    std::optional<vo::Evaluation> evaluation;
    std::optional<vo::SegmentedEvaluation> segmented_evaluation;
    std::string evaluation_failure;  ///< Why there is ground truth but no evaluation.
  };

  void StartFrame();
  void FrameIsRead();
  void FrameIsDone(const vo::FrameResult& result);

  /// The part of a report that the record knows.
  RunReport Report(const Context& context) const;
  /// The segment of each frame.
  std::vector<int> SegmentOfFrames() const;

  /// Throws Error where the file cannot be written.
  void Write(const std::filesystem::path& path, const Context& context) const;
  /// A few lines for people.
  std::string Summary(const Context& context) const;
  /// What a user should know about how the run went, a line each.
  std::vector<std::string> Warnings(const std::string& method) const;

 private:
  using Clock = std::chrono::steady_clock;

  int Resets() const;
  double MedianMatches(int vo::FrameResult::*count) const;
  double Duration() const;

  std::optional<Clock::time_point> run_start_;
  Clock::time_point frame_start_;
  Clock::time_point frame_end_;
  double read_ms_ = 0.0;
  std::vector<vo::FrameResult> frames_;  // Their poses too: 200 bytes a frame.
  std::map<std::string, std::vector<double>> stages_ms_;
};

/// The value of every option of a command, defaults too.
std::map<std::string, std::string> OptionValues(const CLI::App& command);

}  // namespace gluevo::apps
