#include "frame_series.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "markup.h"
#include "sections.h"

namespace gluevo::apps {

namespace {

template <typename Value>
Series FrameSeries(const RunReport& report, const std::string& name, const std::string& style,
                   const Value& value) {
  Series series{name, style, {}, {}, {}};
  for (std::size_t i = 0; i < report.frames.size(); ++i) {
    series.x.push_back(SecondsIn(report, report.frames[i].timestamp_ns));
    series.y.push_back(value(report.frames[i]));
    if (i > 0 && report.frames[i].segment != report.frames[i - 1].segment) {
      series.breaks.push_back(i);
    }
  }
  return series;
}

}  // namespace

Series CountSeries(const RunReport& report, const std::string& name, const std::string& style,
                   int vo::FrameResult::*count) {
  return FrameSeries(report, name, style,
                     [&](const vo::FrameResult& frame) { return frame.*count; });
}

Series PositionSigmaSeries(const RunReport& report, const std::string& style) {
  return FrameSeries(report, "as the estimate knows it (1 sigma)", style,
                     [](const vo::FrameResult& frame) {
                       return std::sqrt(frame.path_covariance.topLeftCorner<3, 3>().trace());
                     });
}

Series StageSeries(const RunReport& report, const std::string& name, const std::string& style,
                   const std::string& stage) {
  Series series{name, style, {}, {}, {}};
  const auto found = report.stages_ms.find(stage);
  // A stage that some frames went without cannot be told apart by frame.
  if (found != report.stages_ms.end() && found->second.size() == report.frames.size()) {
    for (std::size_t i = 0; i < report.frames.size(); ++i) {
      series.x.push_back(SecondsIn(report, report.frames[i].timestamp_ns));
      series.y.push_back(found->second[i]);
    }
  }
  return series;
}

std::vector<ChartMark> ResetMarks(const RunReport& report) {
  std::vector<ChartMark> marks;
  for (std::size_t i = 1; i < report.frames.size(); ++i) {
    if (report.frames[i].segment != report.frames[i - 1].segment) {
      const double time = SecondsIn(report, report.frames[i].timestamp_ns);
      marks.push_back(
          {time, "tracking lost at frame " + std::to_string(i) + ", " + Fixed(time, 1) + " s"});
    }
  }
  return marks;
}

std::vector<std::size_t> ErrorBreaks(const RunReport& report) {
  std::unordered_map<int64_t, int> segment_of;
  for (const vo::FrameResult& frame : report.frames) {
    segment_of[frame.timestamp_ns] = frame.segment;
  }
  std::vector<std::size_t> breaks;
  const std::vector<vo::PoseError>& errors = report.evaluation->errors;
  for (std::size_t i = 1; i < errors.size(); ++i) {
    if (segment_of[errors[i].timestamp_ns] != segment_of[errors[i - 1].timestamp_ns]) {
      breaks.push_back(i);
    }
  }
  return breaks;
}

std::vector<double> KeyframeTimes(const RunReport& report) {
  std::vector<double> times;
  for (const vo::FrameResult& frame : report.frames) {
    if (frame.is_keyframe) {
      times.push_back(SecondsIn(report, frame.timestamp_ns));
    }
  }
  return times;
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) {
    return 0.0;
  }
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(q * static_cast<double>(values.size() - 1)))];
}

}  // namespace gluevo::apps
