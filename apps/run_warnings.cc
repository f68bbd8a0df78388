#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/text.h"
#include "run_metrics.h"

// What people are told about how a run went.
namespace gluevo::apps {
std::vector<std::string> RunMetrics::AllWarnings(const Context& context) const {
  std::vector<std::string> warnings = context.dataset_warnings;
  const std::vector<std::string> of_run = Warnings(context);
  warnings.insert(warnings.end(), of_run.begin(), of_run.end());
  return warnings;
}

std::vector<std::string> RunMetrics::Warnings(const Context& context) const {
  std::vector<std::string> warnings;
  if (context.is_interrupted || !context.failure.empty()) {
    warnings.push_back((context.is_interrupted ? "interrupted" : "ended early") +
                       std::string(" after ") + std::to_string(frames_.size() + left_out_.size()) +
                       " of " + vo::Counted(context.frames_asked, "frame") +
                       (context.is_interrupted ? "" : ": " + context.failure));
  }
  if (!left_out_.empty()) {
    warnings.push_back(vo::Counted(left_out_.size(), "frame") +
                       " left out that cannot be read, the first one: " + left_out_.front().why);
  }
  if (context.live) {
    const std::vector<std::string> of_live = LiveWarnings(*context.live);
    warnings.insert(warnings.end(), of_live.begin(), of_live.end());
  }
  warnings.insert(warnings.end(), context.causes.begin(), context.causes.end());
  // The first frame has nothing to be tracked from.
  constexpr double kNextToNothing = 15.0;
  if (frames_.size() > 1 && MedianMatches(&vo::FrameResult::matched) < kNextToNothing) {
    warnings.emplace_back("matching from frame to frame yields next to nothing");
  } else if (frames_.size() > 1 && MedianMatches(&vo::FrameResult::inliers) < kNextToNothing) {
    warnings.push_back(
        "of the matches from frame to frame next to nothing fits a motion: a frame has " +
        std::to_string(std::lround(MedianMatches(&vo::FrameResult::matched))) + ", of these " +
        std::to_string(std::lround(MedianMatches(&vo::FrameResult::tracked))) +
        " of points whose depth is known, of these " +
        std::to_string(std::lround(MedianMatches(&vo::FrameResult::inliers))) + " that fit");
  }
  if (!frames_.empty() && MedianMatches(&vo::FrameResult::stereo) < kNextToNothing) {
    warnings.emplace_back("matching from left to right yields next to nothing");
  }
  const auto count = [&](bool vo::FrameResult::*flag) {
    return static_cast<std::size_t>(std::count_if(
        frames_.begin(), frames_.end(), [&](const vo::FrameResult& frame) { return frame.*flag; }));
  };
  if (const std::size_t predicted = count(&vo::FrameResult::is_predicted); predicted > 0) {
    warnings.push_back(vo::Counted(predicted, "pose") +
                       " predicted from the motion before: the frames show nothing by which they "
                       "could be located");
  }
  if (const std::size_t bridged = count(&vo::FrameResult::is_bridged); bridged > 0) {
    warnings.push_back(vo::Counted(bridged, "pose") +
                       " where the inertial unit alone leads: the frames show nothing that was "
                       "seen before");
  }
  if (IsStartOverdue(context)) {
    warnings.push_back(InertialSentence(context));
  }
  if (context.imu && !context.imu->clock_fault.empty()) {
    warnings.push_back(context.imu->clock_fault + "; --estimate-time-offset makes up for it");
  }
  if (const std::size_t doubtful = count(&vo::FrameResult::is_doubtful); doubtful > 0) {
    warnings.push_back(vo::Counted(doubtful, "pose") +
                       " doubtful: less than half of what is seen agrees with them (does something "
                       "move that fills the view?)");
  }
  if (const std::size_t left_only = count(&vo::FrameResult::is_left_only); left_only > 0) {
    warnings.push_back(vo::Counted(left_only, "frame") +
                       " located by the left camera alone: the right one shows next to nothing");
  }
  if (Resets() > 0) {
    warnings.push_back("tracking was lost " + vo::Counted(Resets(), "time") +
                       ": poses of different segments are not linked");
  }
  return warnings;
}

bool RunMetrics::IsStartOverdue(const Context& context) const {
  // A start takes some seconds.
  constexpr int64_t kLongNs = 10'000'000'000;
  return context.imu && !context.imu->begin && !frames_.empty() &&
         frames_.back().timestamp_ns - frames_.front().timestamp_ns > kLongNs;
}

std::string RunMetrics::InertialSentence(const Context& context) const {
  if (!context.imu) {
    return "";
  }
  const std::optional<vo::InertialBegin>& begin = context.imu->begin;
  if (!begin) {
    return "The inertial unit has not started: " + context.imu->why_waiting;
  }
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "The inertial unit started "
       << (begin->is_at_rest ? "at rest" : "in motion") << ' '
       << 1e-9 * static_cast<double>(begin->timestamp_ns - frames_.front().timestamp_ns)
       << " s after the first frame";
  const auto newest = std::find_if(
      frames_.rbegin(), frames_.rend(),
      [](const vo::FrameResult& frame) { return frame.inertial && frame.inertial->time_offset_s; });
  if (newest != frames_.rend()) {
    text << std::setprecision(2) << "; its stamps are " << 1e3 * *newest->inertial->time_offset_s
         << " ms (sigma " << 1e3 * newest->inertial->time_offset_sigma_s << ") behind the images'";
  }
  return text.str();
}

std::string RunMetrics::WhyNothingWasRead() const {
  return (left_out_.size() > 1
              ? "none of the " + std::to_string(left_out_.size()) + " frames can be read: "
              : "") +
         left_out_.front().why;
}

void RunMetrics::CheckThatSomethingWasTracked(const Context& context) const {
  const bool is_located =
      std::any_of(frames_.begin(), frames_.end(),
                  [](const vo::FrameResult& frame) { return frame.inliers > 0; });
  if (frames_.size() > 1 && !is_located) {
    throw Error("nothing was tracked over " + vo::Counted(frames_.size(), "frame") +
                (context.causes.empty() ? "" : ": " + context.causes.front()));
  }
}

}  // namespace gluevo::apps
