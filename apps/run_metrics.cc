#include "run_metrics.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "command_line/message.h"
#include "evaluation_json.h"
#include "evaluation_text.h"
#include "frame_metrics.h"
#include "gluevo/nn/isa.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/vo/core/text.h"
#include "json_text.h"
#include "report/processor.h"
#include "stereo_calibration_metrics.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::ordered_json;

double Milliseconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

// Value below which the share `q` of the values lies (nearest rank); 0 of none.
double Quantile(std::vector<double> values, double q) {
  if (values.empty()) {
    return 0.0;
  }
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::lround(q * last))];
}

double PeakMemoryMb() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// As its paper calls it.
std::string NetworkTitle(const std::string& network) {
  return network == "superpoint"  ? "SuperPoint"
         : network == "superglue" ? "SuperGlue"
         : network == "aliked"    ? "ALIKED"
                                  : "LightGlue";
}

void AddOptions(const RunMetrics::Context& context, Json& json) {
  json["options"] = Json::object();
  json["option_origins"] = Json::object();
  for (const auto& [option, values] : context.options) {
    json["options"][option] = values.size() == 1 ? Json(values[0]) : Json(values);
    json["option_origins"][option] = context.origins.origins.at(option);
  }
}

}  // namespace

void RunMetrics::Start() { run_start_ = frame_end_ = Clock::now(); }

void RunMetrics::FrameIsRead(double read_ms) {
  frame_start_ = Clock::now();
  read_ms_ = read_ms;
}

void RunMetrics::FrameIsLeftOut(std::size_t index, const std::string& why) {
  left_out_.push_back({index, why});
}

void RunMetrics::FrameIsDone(const vo::FrameResult& result) {
  frame_end_ = Clock::now();
  networks_.Add(result.tracked_frame);
  vo::FrameResult kept = result;
  // The record must stay small however long the sequence is.
  kept.tracked_frame = {};
  kept.window = {};
  if (log_) {
    log_->Append(kept);
    if (kept.inertial) {
      frames_ = {std::move(kept)};
    }
    return;
  }
  KeepStages(kept);
  frames_.push_back(std::move(kept));
  if (read_ms_) {
    stages_ms_["read"].push_back(*read_ms_);
    stages_ms_["total"].push_back(*read_ms_ + Milliseconds(frame_end_ - frame_start_));
  }
}

void RunMetrics::LoadFrames() {
  frames_ = log_->Read();
  log_.reset();
  for (vo::FrameResult& frame : frames_) {
    KeepStages(frame);
  }
}

void RunMetrics::KeepStages(vo::FrameResult& frame) {
  for (const auto& [stage, ms] : std::exchange(frame.stages_ms, {})) {
    stages_ms_[stage].push_back(ms);
  }
}

int RunMetrics::Resets() const { return frames_.empty() ? 0 : frames_.back().segment; }

std::vector<int> RunMetrics::SegmentOfFrames() const {
  std::vector<int> segments;
  for (const vo::FrameResult& frame : frames_) {
    segments.push_back(frame.segment);
  }
  return segments;
}

double RunMetrics::MedianMatches(int vo::FrameResult::*count) const {
  std::vector<double> counts;
  for (const vo::FrameResult& frame : frames_) {
    counts.push_back(frame.*count);
  }
  return Quantile(std::move(counts), 0.5);
}

double RunMetrics::Duration() const {
  return run_start_ ? Milliseconds(frame_end_ - *run_start_) / 1000.0 : 0.0;
}

RunReport RunMetrics::Report(const Context& context) const {
  RunReport report;
  report.method = context.method;
  report.frames = frames_;
  report.warnings = AllWarnings(context);
  report.evaluation = context.evaluation;
  report.evaluation_failure = context.evaluation_failure;
  report.inertial = InertialSentence(context);
  report.stereo_calibration = TextOfStereoCalibration(frames_);
  report.duration_s = Duration();
  report.stages_ms = stages_ms_;
  report.peak_memory_mb = PeakMemoryMb();
  report.options.reserve(context.options.size());
  for (const auto& [option, values] : context.options) {
    report.options.emplace_back(option, ValueText(values));
  }
  report.weights.reserve(context.weights.size());
  for (const vo::WeightsRecord& record : context.weights) {
    report.weights.push_back({NetworkTitle(record.network), record.source, record.checksum});
  }
  report.version = GLUEVO_VERSION;
  report.processor = ProcessorName();
  report.isa = nn::IsaName(nn::ChooseIsa());
  report.threads = context.threads;
  return report;
}

void RunMetrics::Write(const std::filesystem::path& path, const Context& context) const {
  Json json;
  json["frames"] = frames_.size();
  json["interrupted"] = context.is_interrupted;
  if (!context.failure.empty()) {
    json["failure"] = context.failure;
  }
  json["frames_left_out"] = Json::array();
  for (const LeftOut& left_out : left_out_) {
    json["frames_left_out"].push_back({{"frame", left_out.frame}, {"why", left_out.why}});
  }
  AddMarkedFrames(frames_, json);
  json["frames_with_pose"] = frames_.size();
  json["keyframes"] = std::count_if(frames_.begin(), frames_.end(),
                                    [](const vo::FrameResult& frame) { return frame.is_keyframe; });
  json["resets"] = Resets();
  json["segments"] = SegmentsJson(frames_);
  json["warnings"] = AllWarnings(context);
  json["images_left_out"] = context.images_left_out;
  const double duration = Duration();
  json["duration_s"] = duration;
  json["frames_per_second"] = duration > 0.0 ? static_cast<double>(frames_.size()) / duration : 0.0;
  json["stages_ms"] = Json::object();
  for (const auto& [stage, ms] : stages_ms_) {
    json["stages_ms"][stage] = {{"median", Quantile(ms, 0.5)}, {"p95", Quantile(ms, 0.95)}};
  }
  networks_.AddTo(json);
  json["matches_per_frame"] = {{"found", MedianMatches(&vo::FrameResult::matched)},
                               {"tracked", MedianMatches(&vo::FrameResult::tracked)},
                               {"fit", MedianMatches(&vo::FrameResult::inliers)},
                               {"stereo", MedianMatches(&vo::FrameResult::stereo)},
                               {"moving", MedianMatches(&vo::FrameResult::moving)}};
  if (context.live) {
    AddLive(*context.live, json);
  }
  if (context.imu) {
    json["imu"] = ImuJson(*context.imu, frames_);
  }
  json["stereo_calibration"] = StereoCalibrationJson(frames_);
  json["peak_memory_mb"] = PeakMemoryMb();
  json["isa"] = nn::IsaName(nn::ChooseIsa());
  json["threads"] = context.threads;
  json["weights"] = Json::object();
  for (const vo::WeightsRecord& record : context.weights) {
    json["weights"][record.network] = {{"name", record.source}, {"sha256", record.checksum}};
  }
  json["method"] = context.method;
  for (const auto& [key, name] :
       {std::pair("features", context.features), {"matcher", context.matcher}}) {
    if (!name.empty()) {
      json[key] = name;
    }
  }
  json["preset"] = context.origins.preset;
  json["preset_from"] = context.origins.preset_from;
  AddOptions(context, json);
  if (context.evaluation) {
    AddEvaluation(*context.evaluation, json);
  }
  if (context.segmented_evaluation) {
    AddSegmentedEvaluation(*context.segmented_evaluation, json);
  }
  if (context.loops) {
    AddLoops(*context.loops, json);
  }
  if (!context.evaluation_warning.empty()) {
    json["evaluation_warning"] = context.evaluation_warning;
  }
  if (!context.evaluation_failure.empty()) {
    json["evaluation_failure"] = context.evaluation_failure;
  }
  nn::WriteWholeFile(path, [&](std::ostream& out) { out << JsonText(json); });
}

std::string RunMetrics::Summary(const Context& context) const {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  text << vo::Counted(frames_.size(), "frame") << ", " << vo::Counted(Resets() + 1, "segment")
       << ", " << static_cast<double>(frames_.size()) / std::max(Duration(), 1e-9)
       << " frames a second; median matches: " << MedianMatches(&vo::FrameResult::tracked)
       << " tracked (" << MedianMatches(&vo::FrameResult::inliers) << " fit), "
       << MedianMatches(&vo::FrameResult::stereo) << " stereo\n";
  for (const std::string& sentence :
       {IsStartOverdue(context) ? std::string() : InertialSentence(context),
        TextOfStereoCalibration(frames_)}) {
    text << sentence << (sentence.empty() ? "" : "\n");
  }
  for (const std::string& warning : Warnings(context)) {
    text << "warning: " << OneLine(warning) << '\n';
  }
  if (!context.evaluation_failure.empty()) {
    text << "warning: the ground truth is not used: " << OneLine(context.evaluation_failure)
         << '\n';
  }
  if (!context.evaluation_warning.empty()) {
    text << "warning: evaluation: " << context.evaluation_warning << '\n';
  }
  if (const std::optional<vo::Evaluation>& evaluation = context.evaluation; evaluation) {
    const RpeText rpe = TextOfRpe(*evaluation, 3, 4);
    text << std::setprecision(4) << "ATE " << evaluation->ate_se3_m << " m (SE3), "
         << evaluation->ate_sim3_m << " m (Sim3, scale " << TextOfScale(*evaluation, 4) << "); RPE "
         << rpe.translation << (rpe.is_known ? ", " + rpe.rotation : "") << "; correct motions "
         << evaluation->correct_motions << " of " << evaluation->pairs - 1 << "; coverage "
         << std::setprecision(1) << 100.0 * evaluation->coverage << " %\n";
  }
  if (context.loops) {
    text << TextOfLoops(*context.loops);
  }
  return text.str();
}

}  // namespace gluevo::apps
