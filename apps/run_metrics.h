#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/evaluation/segment_evaluation.h"
#include "gluevo/vo/pipeline/networks.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "live/frame_log.h"
#include "live/live_record.h"
#include "loop_metrics.h"
#include "network_record.h"
#include "options/option_values.h"
#include "options/preset_options.h"
#include "report/run_report.h"
#include "run_imu.h"

namespace gluevo::apps {

/// Gathers what happens to each frame of a run, and writes it as metrics.json.
class RunMetrics {
 public:
  /// What the record says beside the frames.
  struct Context {
    std::string method;
    std::string features;  ///< Empty where the method has none, as the next.
    std::string matcher;
    int threads = 1;
    std::vector<vo::WeightsRecord> weights;  ///< Of the networks that ran.
    OptionValueMap options;
    OptionOrigins origins;
    std::vector<std::string> dataset_warnings;  ///< vo::Dataset's.
    int images_left_out = 0;
    std::optional<vo::Evaluation> evaluation;
    std::optional<vo::SegmentedEvaluation> segmented_evaluation;
    std::string evaluation_warning;  ///< Why its figures say little; empty where they do.
    std::string evaluation_failure;  ///< Why there is ground truth but no evaluation.
    std::size_t frames_asked = 0;    ///< Of the data set; fewer are done where the run ends early.
    bool is_interrupted = false;     ///< By a signal, before its last frame.
    std::string failure;             ///< What ended the run before its last frame.
    std::optional<LoopOutcome> loops;  ///< Where they were looked for.
    std::vector<std::string> causes;   ///< Why tracking yields little, vo::Causes().
    std::optional<ImuRecord> imu;      ///< Where an inertial unit is used.
    std::optional<LiveRecord> live;    ///< Of what came as it happened.
  };

  /// From now on what became of frames is kept on disk (FrameLog), and frames() has the newest one
  /// of which an inertial unit says something only, until LoadFrames().
  void KeepOnDisk(const std::filesystem::path& folder) { log_.emplace(folder); }
  void LoadFrames();

  /// The first frame is about to be read.
  void Start();
  /// The next frame is about to be tracked; `read_ms`: what reading it took. Not called where
  /// frames come by themselves: their record has neither "read" nor "total".
  void FrameIsRead(double read_ms);
  void FrameIsLeftOut(std::size_t index, const std::string& why);
  std::size_t left_out() const { return left_out_.size(); }
  void FrameIsDone(const vo::FrameResult& result);
  /// What was done beside tracking, and what each frame took, milliseconds.
  void AddStage(const std::string& name, std::vector<double> ms) {
    stages_ms_[name] = std::move(ms);
  }

  /// The part of a report that the record knows.
  RunReport Report(const Context& context) const;
  /// What became of each, without its tracks.
  const std::vector<vo::FrameResult>& frames() const { return frames_; }
  /// The segment of each frame.
  std::vector<int> SegmentOfFrames() const;

  /// Throws Error where the file cannot be written.
  void Write(const std::filesystem::path& path, const Context& context) const;
  /// A few lines for people.
  std::string Summary(const Context& context) const;
  /// What a user should know about how the run went, a line each: causes before what they cause.
  std::vector<std::string> Warnings(const Context& context) const;
  /// Those of the data set, which are said before the first frame, and these.
  std::vector<std::string> AllWarnings(const Context& context) const;
  /// Of a run all of whose frames were left out.
  std::string WhyNothingWasRead() const;
  /// Throws Error, with the cause where it is known, where a run of several frames has located
  /// none.
  void CheckThatSomethingWasTracked(const Context& context) const;

 private:
  using Clock = std::chrono::steady_clock;
  struct LeftOut {
    std::size_t frame = 0;
    std::string why;
  };

  /// Moves the times of its stages to those of all frames.
  void KeepStages(vo::FrameResult& frame);
  int Resets() const;
  /// Whether the inertial unit has not started though it had time to, which is warned of.
  bool IsStartOverdue(const Context& context) const;
  /// How the inertial unit started, or why it has not; empty without one.
  std::string InertialSentence(const Context& context) const;
  double MedianMatches(int vo::FrameResult::*count) const;
  double Duration() const;

  std::optional<Clock::time_point> run_start_;
  Clock::time_point frame_start_;
  Clock::time_point frame_end_;
  std::optional<double> read_ms_;
  std::vector<LeftOut> left_out_;
  std::vector<vo::FrameResult> frames_;  // Their poses and covariances too: a kilobyte a frame.
  std::optional<FrameLog> log_;          // Where they are instead.
  std::map<std::string, std::vector<double>> stages_ms_;
  NetworkRecord networks_;
};

}  // namespace gluevo::apps
